"""Real client libraries of Player drive a Pioneer 2 AT through `libgz player`.

They are not part of libgz: a trial runs for each environment variable that has the compiler's flags for one, such as

    PLAYERC_1_6="-I/opt/player16/include /opt/player16/lib/libplayerc.a"    (also PLAYERC_2_0, PLAYERC_2_1, PLAYERC_3)

and is skipped without.
"""

import contextlib
import os
import re
import shlex
import signal
import subprocess
import sys
import time

import pytest
from player_clients import free_port

pytestmark = pytest.mark.trial

WORLD = """<gz:world xmlns:gz="g" xmlns:model="m" xmlns:param="p">
<param:Global><gravity>0 0 -9.8</gravity><stepTime>0.02</stepTime></param:Global>
<model:GroundPlane><id>ground</id></model:GroundPlane>
<model:Pioneer2AT><id>robot1</id><xyz>0 0 0.2</xyz>
  <model:SickLMS200><id>laser1</id><xyz>0.15 0 0</xyz></model:SickLMS200>
  <model:SonyVID30><id>camera1</id><xyz>0.15 0 0.3</xyz></model:SonyVID30>
  <model:Pioneer2Gripper><id>gripper1</id><xyz>0.3 0 0.06</xyz></model:Pioneer2Gripper>
</model:Pioneer2AT>
<model:SimpleSolid><id>wall</id><xyz>4 0 0.5</xyz><shape>box</shape><size>0.5 4 1</size></model:SimpleSolid>
</gz:world>
"""
DEVICES = {"position": "robot1", "laser": "laser1", "sonar": "robot1", "ptz": "camera1", "gripper": "gripper1"}
DEVICES |= {"power": "robot1"}
OLD = 'driver ( name "gz_sim" provides ["simulation:0"] worldfile "robot.world" )\n' + "".join(
    f'driver ( name "gz_{kind}" provides ["{kind}:0"] gz_id "{name}" )\n' for kind, name in DEVICES.items()
)
NEW = re.sub(r'name "gz_\w+"', 'name "gazebo"', OLD).replace("position:0", "position2d:0")

PROGRAM = r"""
#include HEADER
#include <stdio.h>
#include <stdlib.h>
#if VERSION == 16
typedef playerc_position_t robot_t;
#define OPEN PLAYER_ALL_MODE
#define robot(name) playerc_position_##name
#else
typedef playerc_position2d_t robot_t;
#define OPEN PLAYERC_OPEN_MODE
#define robot(name) playerc_position2d_##name
#endif
#if VERSION >= 21
#define CLOSE playerc_gripper_close_cmd(gripper)
#define LIFT playerc_gripper_store_cmd(gripper)
#define CLOSED (gripper->state == 2)
#else
#define CLOSE playerc_gripper_set_cmd(gripper, 2, 0)
#define LIFT playerc_gripper_set_cmd(gripper, 4, 0)
#define CLOSED gripper->paddles_closed
#endif

int main(int count, char **words)
{
  playerc_client_t *client = playerc_client_create(NULL, "127.0.0.1", atoi(words[1]));
  robot_t *robot = robot(create)(client, 0);
  playerc_laser_t *laser = playerc_laser_create(client, 0);
  playerc_sonar_t *sonar = playerc_sonar_create(client, 0);
  playerc_ptz_t *ptz = playerc_ptz_create(client, 0);
  playerc_power_t *power = playerc_power_create(client, 0);
  playerc_gripper_t *gripper = playerc_gripper_create(client, 0);
  int failed = playerc_client_connect(client), i;
  double first = -1.0;

  if (count > 2)
    failed |= playerc_client_datamode(client, atoi(words[2]));
  failed |= robot(subscribe)(robot, OPEN) | playerc_laser_subscribe(laser, OPEN) | playerc_sonar_subscribe(sonar, OPEN);
  failed |= playerc_ptz_subscribe(ptz, OPEN) | playerc_power_subscribe(power, OPEN);
  failed |= playerc_gripper_subscribe(gripper, OPEN);
  failed |= robot(get_geom)(robot) | playerc_sonar_get_geom(sonar) | playerc_laser_get_geom(laser);
  failed |= playerc_client_get_devlist(client) | robot(enable)(robot, 1);
  if (failed) {
    printf("failed: %s\n", playerc_error_str());
    return 1;
  }
  printf("devices %d size %.2f %.2f sonars %d\n", client->devinfo_count, robot->size[0], robot->size[1],
         sonar->pose_count);
  robot(set_cmd_vel)(robot, 0.3, 0.0, 0.0, 1);
  playerc_ptz_set(ptz, 0.5, -0.25, 0.75);
  CLOSE;
  for (i = 0; i < 100000 && (first < 0.0 || robot->info.datatime < first + 4.0); i++) {
    playerc_client_read(client);
    if (first < 0.0 && robot->info.datatime > 0.0)
      first = robot->info.datatime;
  }
  LIFT;
  printf("x %.2f v %.2f y %.2f yaw %.2f\n", robot->px, robot->vx, robot->py, robot->pa);
  printf("scan %d ahead %.2f resolution %.4f\n", laser->scan_count, laser->scan[90][0], laser->scan_res);
  printf("sonar %d of %.2f\n", (int) sonar->scan_count, sonar->scan[4]);
  printf("ptz %.2f %.2f %.2f\n", ptz->pan, ptz->tilt, ptz->zoom);
  printf("volts %.1f closed %d\n", power->charge, CLOSED);
  robot(set_cmd_vel)(robot, 0.0, 0.0, 0.0, 1);
  first = robot->info.datatime;
  for (i = 0; i < 100000 && robot->info.datatime < first + 2.0; i++)
    playerc_client_read(client);
  printf("still %.2f\n", robot->vx);
  return playerc_client_disconnect(client);
}
"""
LIBRARIES = {"PLAYERC_1_6": 16, "PLAYERC_2_0": 20, "PLAYERC_2_1": 21, "PLAYERC_3": 30}
MODES = {16: ("", "2"), 20: ("", "1", "2"), 21: ("", "1"), 30: ("", "1")}  # the library's own one, and others
CASES = [(name, mode) for name, version in LIBRARIES.items() for mode in MODES[version]]


@contextlib.contextmanager
def serve(folder, version):
    """A Player server in a process of its own; gives its port."""
    (folder / "robot.world").write_text(WORLD)
    (folder / "robot.cfg").write_text(OLD if version == 16 else NEW)
    command = [sys.executable, "-m", "libgz", "player", "robot.cfg", "-p", str(port := free_port())]
    environment = os.environ | {"TMP": str(folder)}
    with subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, text=True, env=environment) as server:
        try:
            assert server.stdout.readline().startswith("Player on ")
            time.sleep(0.5)  # the robot comes to rest
            yield port
        finally:
            server.send_signal(signal.SIGTERM)


@pytest.mark.parametrize(("variable", "mode"), CASES)
def test_the_library_drives(tmp_path, variable, mode):
    flags, version = os.environ.get(variable), LIBRARIES[variable]
    if not flags:
        pytest.skip(f"the environment variable {variable} names no client library")
    (tmp_path / "drive.c").write_text(PROGRAM)
    header = "<playerc.h>" if version == 16 else "<libplayerc/playerc.h>"
    defines = [f"-DVERSION={version}", f"-DHEADER={header}"]
    subprocess.run(["gcc", "-w", "-o", "drive", "drive.c", *defines, *shlex.split(flags)], cwd=tmp_path, check=True)
    with serve(tmp_path, version) as port:
        words = ["./drive", str(port), *([mode] if mode else [])]
        done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stdout + done.stderr
    found = {line.split()[0]: [float(n) for n in re.findall(r"-?\d+\.?\d*", line)] for line in done.stdout.splitlines()}
    assert found["devices"] == [7, 0.53, 0.38, 16]
    x, speed, y, yaw = found["x"]
    assert 1.0 < x < 1.3
    assert (speed, y, yaw) == pytest.approx((0.3, 0.0, 0.0), abs=0.03)
    count, ahead, resolution = found["scan"]
    assert (count, resolution) == (181, 0.0175)
    assert ahead == pytest.approx(4.0 - 0.25 - 0.15 - x, abs=0.3)
    assert found["sonar"][0] == 16
    assert found["ptz"] == pytest.approx((0.5, -0.25, 0.75), abs=0.03)
    assert found["volts"] == [pytest.approx(12.4, abs=0.1), 1]
    assert found["still"] == [pytest.approx(0.0, abs=0.02)]
