"""Laws at ports: physics that no list holds, located where parts meet and drawn as a curve (theory.md 22).

A port is where parts of a machine meet. It sees efforts, places, time and history, and answers with an extra motion or
wrench. Where no named effect fits, the law itself is unknown and has a Gaussian-process prior; the machine's own maps
carry it to the readings, and the evidence decides which laws are there.
"""
