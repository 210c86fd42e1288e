# load: mocks_numpy.py
# load: line 6: AttributeError: scripts cannot replace numpy.asarray

from unittest import mock

mock.patch('numpy.asarray', max).start()

def control(robotNo, nbRobots, poses, t):
    return 0.1, 0.1
