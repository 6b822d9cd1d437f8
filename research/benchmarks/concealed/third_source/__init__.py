"""A third source of concealed cases: bodies by finite elements, published curves, equilibria in plain numpy.

Plates, pedestals, links and warming walls are solved with scikit-fem; contacts, films, rubber, creep, presliding, gears
and cables follow the curves of their literature. What makes cases here shares nothing with the virtual laboratory, with
the engines of the second source nor with the program under test; asking, keeping and judging are those of all sources.
"""
