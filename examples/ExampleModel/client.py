"""A control program: drives the example robot half a metre forward, then turns it left.

Start the world first:  gazebo examples/ExampleModel/example.world
"""

import sys

from libgz import Client, GazeboError


def main(server_id: int = 0) -> int:
    try:
        with Client(server_id, timeout=5.0) as client:
            robot = client.position("robot1")
            robot.command(vx=0.2)
            while robot.pose[0] < 0.5:
                client.wait(timeout=1.0)
            robot.command(vyaw=0.5)
            while robot.pose[2] < 1.0:
                client.wait(timeout=1.0)
            robot.command()
            x, y, yaw = robot.pose
            print(f"odometry: x {x:.2f} m, y {y:.2f} m, yaw {yaw:.2f} rad")
    except GazeboError as error:
        print(f"client: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(*map(int, sys.argv[1:])))
