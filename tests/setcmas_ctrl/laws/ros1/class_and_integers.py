import numpy
from rviz_marker import *
import rviz_marker_array as rma

class Pid:
    def __init__(self, kp, ki):
        self.kp, self.ki, self.sum = kp, ki, 0.
    def __call__(self, e, dt):
        self.sum += e*dt
        return self.kp*e + self.ki*self.sum

pidX = Pid(0.8, 0.)
pidY = Pid(0.8, 0.)
wp = 0
WPL = numpy.array([[1, 1], [-1, 1]])
tOld = 0

def control(robotNo, nbRobots, poses, t):
    global wp, tOld
    target = WPL[wp]
    publish_marker(target[0], target[1], 0, robotNo, color=[1, 1, 0], scale=0.3, marker_name='wp_ref', alpha=0.5)
    rma.publish_marker(x=target[0], y=target[1], z=0, robotNo=robotNo, marker_name='history')
    if numpy.linalg.norm(target - poses[0:2, robotNo-1]) < 0.3:
        wp = (wp+1) % 2
        print(f'waypoint {wp}')
    dt = t - tOld
    tOld = t
    if nbRobots > 50:
        return 0, 0
    return numpy.float32(pidX(target[0]-poses[0, robotNo-1], dt)), numpy.float64(pidY(target[1]-poses[1, robotNo-1], dt))
