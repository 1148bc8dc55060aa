"""The proof: a robot that is built and simulated without any of the chain's code.

Bodies and closed loops are MuJoCo's, gears, motion and sensors are written here once more. It
imports foundation and recording (to write flat files), and the diagnosis only where answers are
scored. Needs the extra `proof`.
"""
