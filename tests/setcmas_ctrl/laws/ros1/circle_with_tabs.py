import numpy as np
import rviz_marker_array

R = 1
x_old = None

# tabs, other names of the arguments, a list as the result
def control(i, n, X, time):
	global x_old
	ref = [R*np.cos(0.5*time), R*np.sin(0.5*time)]
	rviz_marker_array.publish_marker(ref[0], ref[1], 0, i, [1, 0, 0], 0.1, "traj_ref", 0.8)
	v = [0.5*(ref[0]-X[0, i-1]), 0.5*(ref[1]-X[1, i-1])]
	if x_old is not None:
		v[0] += 0.01*(x_old - X[0, i-1])
	x_old = X[0, i-1]
	return v
