"""A control program: drives a robot forward until its laser sees something at a distance of one metre.

python stop_at_wall.py SERVER_ID
"""

import sys

import libgz

with libgz.Client(int(sys.argv[1]), timeout=10.0) as client:
    robot, laser = client.position("robot1"), client.laser("laser1")
    robot.command(vx=0.1)  # [m/s]
    while client.wait(timeout=5.0):
        ahead = laser.ranges[80:101]  # [m], the middle of 181 beams
        if laser.time > 0.0 and len(ahead) and ahead.min() < 1.0:
            robot.command(vx=0.0)
            break
    else:
        sys.exit("the server does not answer")
