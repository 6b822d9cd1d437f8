"""A second source of concealed cases: machines solved by other people's engines.

Elastic frames with P-Delta and uniaxial materials (OpenSees, Pynite) and an arm with tendons, stops and springs
(MuJoCo). What makes cases here shares no code with the virtual laboratory and none with the program under test; asking,
keeping and judging are those of the first source (`research.benchmarks.concealed.pipeline`).
"""
