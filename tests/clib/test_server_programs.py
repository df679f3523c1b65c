"""C programs and servers: errors of clients, the end of a server, and servers in C."""

import os
import subprocess
import threading
import time
from pathlib import Path

import pytest
from c_programs import compile_c, needs_compiler, run
from served import serve

import libgz
from libgz.clib import library
from libgz.transport.semaphores import SemaphoreSet
from libgz.transport.server import Server

FAILURES = r"""
#include <stdio.h>
#include <stdlib.h>
#include <gazebo.h>

int main(int count, char **words)
{
    int id = atoi(words[count - 1]);
    gz_client_t *client = gz_client_alloc();
    gz_position_t *position = gz_position_alloc();
    gz_camera_t *camera = gz_camera_alloc();

    gz_error_init(1, 0);
    printf("%d", gz_client_query(client, id + 1));
    printf(" %d", gz_client_query(client, id));
    printf(" %d", gz_client_connect_wait(client, id, 16));
    printf(" %d", gz_client_connect_wait(client, id + 1, 0));
    printf(" %d", gz_client_connect(client, id));
    printf(" %d", gz_client_wait(client));
    printf(" %d", gz_position_open(position, client, NULL));
    printf(" %d", gz_position_open(position, client, "a.b"));
    printf(" %d", gz_position_open(position, client, "nobody"));
    printf(" %d", gz_camera_open(camera, client, "short"));
    printf(" %d\n", gz_camera_open(camera, client, "old"));
    printf("%s\n", gz_error_str());
    return 0;
}
"""


@needs_compiler
def test_the_errors_are_those_of_the_old_library(tmp_path, flags, server):
    (Path(server.path) / "camera.short").write_bytes(bytes(100))
    (Path(server.path) / "camera.old").write_bytes(bytes(921776))
    done = run(compile_c(tmp_path, FAILURES, *flags), server.server_id)
    codes, last = done.stdout.splitlines()
    assert codes.split() == ["1", "0", "-1", "-1", "0", "0", "-1", "-1", "-1", "-1", "-1"]
    assert last == "expected file size: 921776 < 0"
    files, texts = zip(*(line.split(" ", 1) for line in done.stderr.splitlines()), strict=True)
    assert texts == (
        "invalid client ID [16]",
        "Failed to allocate semaphore [No such file or directory]",
        "The server does not appear to be running",
        "interface [position] id is NULL",
        "invalid id [a.b] (must not contain '.')",
        f"error opening device file {server.path}/position.nobody : No such file or directory",
        "expected file size: 921776 < 100",
        "expected file size: 921776 < 0",
    )
    assert all(word.partition(":")[0] in library.SOURCES and word.partition(":")[2].isdigit() for word in files)


OPENER = r"""
#include <stdlib.h>
#include <gazebo.h>

int main(int count, char **words)
{
    gz_client_t *client = gz_client_alloc();
    (void) count;
    gz_client_connect(client, atoi(words[1]));
    return gz_position_open(gz_position_alloc(), client, words[2]) != 0;
}
"""


@needs_compiler
def test_files_of_other_users_and_links_are_not_opened(tmp_path, flags, server):
    serve(server)
    program = compile_c(tmp_path, OPENER, *flags)
    run(program, server.server_id, "robot1")
    (Path(server.path) / "position.link").symlink_to(Path(server.path) / "position.robot1")
    assert "symbolic links" in run(program, server.server_id, "link", code=1).stderr
    if os.geteuid() == 0:
        os.chown(server.path, 65534, -1)
        try:
            done = run(program, server.server_id, "robot1", code=1)
        finally:
            os.chown(server.path, 0, -1)
        assert f"{server.path} belongs to another user (uid 65534)" in done.stderr


WAITER = r"""
#include <stdio.h>
#include <stdlib.h>
#include <gazebo.h>

int main(int count, char **words)
{
    gz_client_t *client = gz_client_alloc();

    if (gz_client_connect_wait(client, atoi(words[count - 1]), 0) != 0)
        return 1;
    while (gz_client_wait(client) == 0)
        puts("post");
    return 9;
}
"""


@needs_compiler
def test_a_wait_ends_with_an_error_when_the_server_ends(tmp_path, flags, wire):
    program = compile_c(tmp_path, WAITER, *flags)
    server = Server(wire)
    server.start()
    semaphores = SemaphoreSet.attach(wire)

    def stop_when_it_waits():
        end = time.monotonic() + 20
        while not semaphores.waiting(0) and time.monotonic() < end:
            time.sleep(0.01)
        server.stop()

    stopper = threading.Thread(target=stop_when_it_waits)
    stopper.start()
    done = run(program, wire, code=9)
    stopper.join()
    assert "error on semaphore wait [Identifier removed]" in done.stderr


SERVER = r"""
#include <stdio.h>
#include <stdlib.h>
#include <gazebo.h>

int main(int count, char **words)
{
    gz_server_t *server = gz_server_alloc();
    gz_position_t *position = gz_position_alloc();
    gz_sim_t *sim = gz_sim_alloc();

    if (gz_server_init(server, atoi(words[1]), count > 2) != 0)
        return 1;
    gz_position_create(position, server, "robot1", "Tester", 7, 3);
    gz_sim_create(sim, server, "default");
    position->data->pos[0] = 1.5;
    gz_position_post(position);
    puts("up");
    fflush(stdout);
    if (getchar() == 'k')
        return 2; /* a crash */
    printf("%.2f\n", position->data->cmd_vel_pos[0]);
    gz_position_destroy(position);
    gz_sim_destroy(sim);
    return gz_server_fini(server);
}
"""


@needs_compiler
def test_a_server_in_c_serves_python(tmp_path, flags, wire):
    program = compile_c(tmp_path, SERVER, *flags)
    command = [str(program), str(wire)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout.readline() == "up\n"
        with libgz.Client(wire) as client:
            robot = client.position("robot1")
            assert (robot.pose[0], robot.data.head.model_id) == (1.5, 7)
            assert client.wait(timeout=5.0)
            robot.command(vx=0.25)
        second = run(program, wire, code=1)
        assert "There appears to be another server running." in second.stderr
        with pytest.raises(libgz.ServerError):
            Server(wire).start()
        assert process.communicate("q", timeout=30)[0] == "0.25\n"
    assert process.returncode == 0
    assert not libgz.Client.query(wire)


@needs_compiler
def test_a_crashed_c_server_is_replaced(tmp_path, flags, wire):
    program = compile_c(tmp_path, SERVER, *flags)
    for words in ([wire], [wire, "-f"]):
        crash = subprocess.run([str(program), *map(str, words)], input="k", text=True, timeout=30, check=False)
        assert crash.returncode == 2
    server = Server(wire)
    server.start()
    server.stop()
