"""Viewer: shows a running world in browsers, and passes on what their users do."""

from __future__ import annotations

import base64
import contextlib
import io
import logging
import math
import queue
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import viser
from numpy.typing import NDArray
from PIL import Image

from libgz.base.closing import Closing
from libgz.base.errors import ClosedError, GazeboError, InterfaceError, ServerGoneError
from libgz.transport.observer import ObservedState
from libgz.view.driving import Driver, Robot, robots_of
from libgz.view.gate import Gate, may_control
from libgz.view.marks import Marks, sensor_name
from libgz.view.panel import Overlay, Panel
from libgz.view.parts import STEERED, Part, interface_parts, joint_parts, light_parts
from libgz.view.scene import Look, SceneView
from libgz.view.source import Controls, Source

__all__ = ["HOST", "PORT", "RATE", "Viewer"]

log = logging.getLogger("libgz.view")

HOST, PORT, RATE = "127.0.0.1", 8080, 30.0
STATUS_PERIOD, IMAGE_PERIOD, ASK_PERIOD, RETRY = 0.25, 0.2, 0.2, 0.5  # [s]
ALONE_PERIOD = 0.5  # [s] between two frames while nobody watches
LARGEST_SHARE = 0.4  # of a core that frames may take; beyond that there are fewer
KEPT = 60.0  # [s] for the time line
FAR_AWAY = 60.0  # [m] models beyond do not count for the first view, if there are others
GROUND = 25.0  # [m] what is larger does not count either, if there is something else
FLAT = 0.05  # [m]
CLEAR, TALL = 0.7, 3.0  # [m] around a model that is inserted, and above it
SHADOW_DELAY = 2.5  # [s]
HANDLES = 110.0  # [px]


class Viewer(Closing):
    """A page that shows a world, on a port of this machine.

    Args:
        source: of the scene and the states.
        controls: what users can do; None: they only watch.
        host: address to bind.
        port: first one that is tried; a busy one moves to the next.
        rate: largest number of frames per second [Hz].
        overlays: the panels of GUI plugins, by name.
        wait: whether a frame waits for the answers to its requests, as one of a recording does.
        token: of the address that can control; None for a new one.

    Attributes:
        failures: how many frames and actions ended with an error that is none of libgz.

    Raises:
        GazeboError: no port is free.
    """

    def __init__(
        self,
        source: Source,
        controls: Controls | None = None,
        *,
        host: str = HOST,
        port: int = PORT,
        rate: float = RATE,
        overlays: Callable[[], Mapping[str, Overlay]] | None = None,
        wait: bool = False,
        token: str | None = None,
    ) -> None:
        self._wait, self.failures = wait, 0
        self.source, self.controls, self.rate = source, controls, rate
        self._overlays = overlays
        self._actions: queue.SimpleQueue[Callable[[], object]] = queue.SimpleQueue()
        self._asking = ThreadPoolExecutor(1, "viewer")
        self._pending: set[str] = set()
        self.gate = Gate(host, "libgz", self._take_note, token)
        with self.gate.guarding(), contextlib.redirect_stdout(io.StringIO()):
            self.page = viser.ViserServer(host, port, verbose=False)
        self.page.scene.world_axes.visible = False
        self._root = self.page.scene.add_frame("/world", show_axes=False)
        self.view = SceneView(self.page, source, lambda name, _client: self.do(lambda: self.select(name)))
        self.marks = Marks(self.page, self.view, controls)
        self._can: frozenset[str] = controls.abilities if controls is not None else frozenset()
        self.panel = Panel(self.page, self._can, self.do, self)
        self.driver = self._new_driver()
        self._robots: dict[str, Robot] = {}
        self._inventory: dict[str, Any] = {"drives": [], "keys": False}
        self._state: ObservedState | None = None
        self._revision = -1
        self._selected = ""
        self._pictures: dict[str, NDArray[np.uint8]] = {}  # of SDF cameras
        self._details: dict[str, Any] = {}
        self._follow = self._following = False
        self._offset: NDArray[np.float64] = np.zeros(3)
        self._handle: Any = None
        self._held = False  # whether a user holds the handles
        self._history: deque[tuple[float, float, int]] = deque(maxlen=12)
        self._wanted_time: float | None = None
        self._next = dict.fromkeys(("status", "image", "ask", "move", "log"), 0.0) | {"shadows": math.inf}
        self._due = self._shown = 0.0
        self._gone = False
        self._aimed = False
        self._ended = threading.Event()
        self.page.on_client_connect(self._welcome)

    def _new_driver(self) -> Driver | None:
        return Driver(self.controls) if self.controls is not None and self._can & {"interfaces", "publish"} else None

    @property
    def url(self) -> str:
        """The address of the page that can control."""
        return f"{self.watch_url}?token={self.gate.token}"

    @property
    def watch_url(self) -> str:
        """The address of the page that only watches."""
        host = {"0.0.0.0": "127.0.0.1", "::": "[::1]"}.get(self.gate.host, self.gate.host)
        return f"http://{host}:{self.page.get_port()}/"

    def close(self) -> None:
        """End the page. Can be called twice."""
        if self._ended.is_set():
            return
        self._ended.set()
        if self.driver is not None:
            with contextlib.suppress(GazeboError):
                self.driver.choose(None)
        self._asking.shutdown(wait=False, cancel_futures=True)
        with contextlib.redirect_stdout(io.StringIO()):
            self.page.stop()

    # The loop --------------------------------------------------------------------------------------------------------

    def do(self, action: Callable[[], object]) -> None:
        """Call an action between two frames; safe in every thread."""
        self._actions.put(action)

    def run(self, stopped: Callable[[], bool] = lambda: False) -> None:
        """Show frames until `stopped` says so, or `close` is called."""
        while not stopped() and not self._ended.is_set():
            self.tick()
            time.sleep(min(max(self._due - time.monotonic(), 0.0), 0.5))

    def tick(self) -> None:
        """Do what users did, and show a frame if it is time for one; for programs with a loop of their own."""
        begin = time.monotonic()
        self.act()
        if begin < self._due:
            return
        if self.page.get_clients() or begin >= self._shown + ALONE_PERIOD or self._state is None:
            self._shown = begin
            self._attempt(self.frame)
        now = time.monotonic()
        self._due = max(self._due + 1.0 / self.rate, begin + (now - begin) / LARGEST_SHARE, now)

    def act(self) -> None:
        """Do what users did since the last frame; what is refused is shown to them."""
        while True:
            try:
                action = self._actions.get_nowait()
            except queue.Empty:
                break
            self._attempt(action)
        if self.driver is not None:
            self._attempt(self.driver.act)

    def _attempt(self, action: Callable[[], object]) -> None:
        """Call an action. The viewer survives what it raises: pages close at any moment, and send what they like."""
        try:
            action()
        except GazeboError as error:
            self._report(str(error))
        except Exception:
            self.failures += 1
            if self.failures & (self.failures - 1) == 0:  # 1, 2, 4, 8 ...: not each of thirty a second
                log.exception("the viewer continues after an error (%d so far)", self.failures)

    def _report(self, text: str) -> None:
        log.warning("%s", text)
        for client in self.page.get_clients().values():
            with contextlib.suppress(Exception):  # a page that is being closed
                client.add_notification("libgz", text[:500], color="red", auto_close_seconds=6.0)

    def frame(self, now: float | None = None) -> None:
        """Show the present state; `now` is the real time [s], of which images and texts have some frames a second."""
        now = time.monotonic() if now is None else now
        try:
            if self._gone:
                self._come_back(now)
                return
            state = self.source.state()
            if state.revision != self._revision:
                state = self._show_scene(state)
            changed = self._state is None or state.number != self._state.number
            self._state = state
        except ServerGoneError:
            self._lose()
            return
        except InterfaceError as error:
            self.panel.set_status({}, str(error))
            return
        if changed:
            self.view.move(state)
            self.marks.show(state)
            self._follow_model(state)
            self.marks.select(self.view.ids.get(self._selected), state)
        self._move_handle(state)
        self._show_rest(state, now)

    def _show_scene(self, state: ObservedState) -> ObservedState:
        """Show the scene that belongs to the present state, which is returned."""
        for _ in range(100):
            scene = self.source.scene
            if scene["revision"] == state.revision:
                break
            state = self.source.state()
        self.view.show(scene)
        self._revision = state.revision
        self.panel.set_options("model", [e["id"] for e in scene["entities"] if e["kind"] != "joints"], self._selected)
        if not self._aimed:
            self._aim(state)
        self._ask_inventory()
        self.gate.notify(driving=self._driving, title=f"{scene['world']} - libgz")
        return state

    def _aim(self, state: ObservedState) -> None:
        """Place the pages' cameras where the world's file wants them, or so that its models fill the page."""
        self._aimed = True
        view = self.view.scene["view"]
        camera = self.page.initial_camera
        if view is not None:
            position, (u, x, y, z) = np.array(view[:3]), view[3:]
            ahead = np.array((1 - 2 * (y * y + z * z), 2 * (x * y + u * z), 2 * (x * z - u * y)))
            reach = max(abs(float(position[2])) / max(-float(ahead[2]), 0.3), 2.0)
            place, target = position, position + ahead * reach
        else:
            place, target = self._overview(state)
        camera.up, camera.position, camera.look_at = (0.0, 0.0, 1.0), place, target
        camera.near, camera.far = 0.02, 4000.0
        for client in self.page.get_clients().values():
            client.camera.position, client.camera.look_at = place, target

    def _overview(self, state: ObservedState) -> tuple[NDArray[Any], NDArray[Any]]:
        found = [
            (entity, box)
            for number, entity in self.view.entities.items()
            if (box := self.view.bounds(number, state)) is not None
        ]
        boxes = [(entity, box) for entity, box in found if np.abs(box).max() < FAR_AWAY] or found
        moving = [box for entity, box in boxes if not entity["static"]]
        small = [box for _, box in boxes if np.ptp(box, axis=0).max() < GROUND]
        large = [box for _, box in boxes if np.ptp(box[:, 2]) > FLAT]  # terrain; a plane has no end worth showing
        everything = _around(moving or small or large)
        robots = _around([box for entity, box in boxes if entity["interfaces"] and not entity["static"]])
        if everything is None:
            return np.array((-4.0, -4.0, 3.0)), np.zeros(3)
        middle, size = everything
        if robots is not None:
            middle, size = robots[0], min(size, 5.0 * robots[1])
        return middle + max(size, 1.5) * np.array((-0.8, -0.95, 0.65)), middle

    # Coming and going ------------------------------------------------------------------------------------------------

    async def _welcome(self, client: viser.ClientHandle) -> None:
        """Greet a page that was opened."""
        if len(self.page.get_clients()) <= 1:
            self.do(self._delay_shadows)
        if not may_control.get():
            text = "This address has no token: you can look around, but not control."
            client.add_notification("Watching", text, color="blue", auto_close_seconds=8.0)

    def _delay_shadows(self) -> None:
        """Show no shadows at first: without a GPU they take most of the time until a page shows the world."""
        self._next["shadows"] = time.monotonic() + SHADOW_DELAY
        self.view.show_shadows(False)

    def choose_shadows(self) -> None:
        """Whether there are shadows, as the users' switch says."""
        self._next["shadows"] = math.inf
        self.view.show_shadows(bool(self.panel.shadows.value))

    def _lose(self) -> None:
        """The server has ended."""
        self._gone = True
        self.panel.set_status({}, "The server has ended. Waiting for the next one ...")
        self.gate.notify(driving=False)
        if self.controls is not None:
            self.controls.reconnect()

    def _come_back(self, now: float) -> None:
        if now < self._next["ask"]:
            return
        self._next["ask"] = now + RETRY
        try:
            self.source.reconnect()
        except (ServerGoneError, InterfaceError):
            return
        self._gone, self._revision, self._state, self._aimed = False, -1, None, False
        self._selected, self._robots, self._wanted_time = "", {}, None
        if self.controls is not None and self.controls.abilities != self._can:
            self._can = self.controls.abilities
            self.page.gui.reset()
            self.panel = Panel(self.page, self._can, self.do, self)
            self.driver = self._new_driver()
        self._inventory, self._details = {"drives": [], "keys": False}, {}
        self._history.clear()
        self.view.clear()
        self.marks.clear()
        self._pending.clear()

    # Requests --------------------------------------------------------------------------------------------------------

    def ask(self, verb: str, argument: str = "-", then: Callable[[Any], object] | None = None, **content: Any) -> None:
        """Send a request to the server, without waiting; `then` is called with the answer, between two frames."""
        controls = self.controls
        if controls is None:
            return

        def work() -> None:
            try:
                answer = controls.ask(verb, argument, **content)
                self._pending.discard(verb)
                if then is not None:
                    self.do(lambda: then(answer))
            except GazeboError as error:
                text = str(error)
                if not self._gone:
                    self.do(lambda: self._report(text))
            finally:
                self._pending.discard(verb)

        self._pending.add(verb)
        if self._wait:
            work()
            self.act()
            return
        with contextlib.suppress(RuntimeError):  # the viewer is closed
            self._asking.submit(work)

    def _ask_inventory(self) -> None:
        def learn(answer: Any) -> None:
            self._inventory = answer or self._inventory
            self._list_robots()

        self._list_robots()
        if "inventory" in self._can:
            self.ask("inventory", then=learn)
            if len(getattr(self.panel, "catalogue", ()) and self.panel.catalogue.options) <= 1:
                self.ask("catalogue", then=lambda names: self.panel.set_options("catalogue", names or []))

    def _list_robots(self) -> None:
        if self.driver is None:
            return
        robots = {robot.label: robot for robot in robots_of(self.view.scene, self._inventory["drives"])}
        if robots != self._robots:
            had = set(self._robots)
            self._robots = robots
            present = self.driver.robot
            if (present is None and not had) or (present is not None and present.label not in robots):
                self.choose_robot(next(iter(robots), ""))
        self.panel.set_options("robot", robots, self.driver.robot.label if self.driver.robot is not None else "")

    # What users do ---------------------------------------------------------------------------------------------------

    @property
    def _driving(self) -> bool:
        return self.driver is not None and self.driver.robot is not None

    def press(self, label: str) -> None:
        """One of the buttons pause, run, step, reset."""
        if label in ("pause", "run"):
            self.ask("pause", "on" if label == "pause" else "off")
        elif label == "step":
            self.ask("step", "1")
        else:
            self.ask(label)

    def press_overlay(self, overlay: Overlay, label: str) -> None:
        """A button of a GUI plugin."""
        overlay.Press(label)

    def set_speed(self, speed: float) -> None:
        """The slider of the speed."""
        self.ask("speed", f"{speed:g}")

    def seek(self, moment: float) -> None:
        """Go to a time of the log that is played [s]."""
        self._wanted_time = moment
        self._seek_on()

    def _seek_on(self) -> None:
        """Send the last time that was wanted, once the request before has been answered."""
        if self._wanted_time is not None and "seek" not in self._pending:
            moment, self._wanted_time = self._wanted_time, None
            self.ask("seek", f"{moment:g}")

    def choose_robot(self, label: str) -> None:
        """Drive another robot, or none."""
        if self.driver is None:
            return
        self.driver.choose(self._robots.get(label))
        self.panel.set_options("robot", self._robots, label)
        self._show_parts()
        self.gate.notify(driving=self._driving, title=f"{self.view.scene.get('world', '')} - libgz")

    def set_drive(self, speed: float | None = None, turn: float | None = None) -> None:
        """Velocities at full deflection [m/s], [rad/s]."""
        if self.driver is not None:
            self.driver.speed = self.driver.speed if speed is None else speed
            self.driver.turn = self.driver.turn if turn is None else turn

    def select(self, name: str) -> None:
        """Select a model by its id; an empty one selects none."""
        number = self.view.ids.get(name)
        while number is not None and self.view.entities[number]["id"] != name:
            number = None
        self._selected = name if number is not None else ""
        self._details = {}
        self.panel.set_options("model", list(self.panel.model.options[1:]), self._selected)
        self._drop_handle()
        self._show_model_parts()
        if self._selected and "describe" in self._can:
            self.ask("describe", then=self._learn_details, name=name)
        if self._state is not None:
            self.marks.select(number, self._state)
            self._show_info(self._state)

    def _learn_details(self, answer: Any) -> None:
        self._details = answer or {}

    def set_follow(self, on: bool) -> None:
        """Whether the view follows the selected model."""
        self._follow, self._following = on, False
        if not on:
            offset, self._offset = self._offset, np.zeros(3)
            self._root.position = np.zeros(3)
            for client in self.page.get_clients().values():
                place, target = client.camera.position + offset, client.camera.look_at + offset
                client.camera.position, client.camera.look_at = place, target

    def set_handles(self, on: bool) -> None:
        """Whether the selected model has handles."""
        if not on:
            self._drop_handle()

    def set_mark(self, name: str, on: bool) -> None:
        """Show or hide marks."""
        self.marks.switch(name, on)
        if self._state is not None:
            self.marks.show(self._state)

    def set_look(self, name: str, on: bool) -> None:
        """Wireframe, or collision shapes instead of visible ones."""
        now = self.view.look
        self.view.look = Look(**{"wireframe": now.wireframe, "collisions": now.collisions, name: on})
        if self.view.scene and self._state is not None:
            self.view.show(self.view.scene)
            self.view.move(self._state)

    def set_keep(self, on: bool) -> None:
        """Whether the server keeps states for the time line."""
        self.ask("keep", f"{KEPT if on else 0.0:g}")

    def rewind(self, seconds: float) -> None:
        """Go back [s]."""
        self.ask("rewind", f"{seconds:g}")

    def insert(self, name: str) -> None:
        """Insert a model of the catalogue where the views look at the ground."""
        place = [0.0, 0.0, 0.0]
        for client in self.page.get_clients().values():
            eye, target = np.array(client.camera.position), np.array(client.camera.look_at)
            down = eye[2] - target[2]
            place = (eye + (target - eye) * (eye[2] / down) if down > 1e-3 else target).tolist()
            place = [min(max(part, -100.0), 100.0) for part in place[:2]] + [0.0]
        self.ask("insert", model=name, pose=[*self._free_place(np.array(place) + self._offset), 1.0, 0.0, 0.0, 0.0])

    def _free_place(self, wanted: NDArray[Any]) -> list[float]:
        """The place nearest to another one on the ground that is clear of all models [m]."""
        state = self._state
        boxes = [] if state is None else [self.view.bounds(number, state) for number in self.view.entities]
        corners = [box for box in boxes if box is not None and box[0][2] < TALL and np.ptp(box, axis=0).max() < 50.0]
        angles = np.linspace(0.0, 2.0 * math.pi, 16, endpoint=False)
        for radius in np.arange(0.0, 30.0, 0.5):
            for angle in angles if radius else angles[:1]:
                place = wanted[:2] + radius * np.array((math.cos(angle), math.sin(angle)))
                if all(np.any(place < low[:2] - CLEAR) or np.any(place > high[:2] + CLEAR) for low, high in corners):
                    return [*place.tolist(), 0.0]
        return [*wanted[:2].tolist(), 0.0]

    def delete(self) -> None:
        """Delete the selected model."""
        if self._selected:
            self.ask("delete", name=self._selected)
            self.select("")

    def save(self) -> None:
        """Save the world."""

        def done(path: Any) -> None:
            for client in self.page.get_clients().values():
                client.add_notification("Saved", str(path or "the world's file"), color="green", auto_close_seconds=5.0)

        self.ask("write", then=done)

    def _take_note(self, note: dict[str, Any], page: int) -> None:
        """A note of a page's script; in the page's thread."""
        driver = self.driver
        if driver is None:
            return
        if note.get("closed"):
            self.do(lambda: driver.leave(page))
        elif "drive" in note:
            self.do(lambda: driver.want(page, note["drive"]))
        elif isinstance(note.get("key"), int):
            key = note["key"]
            self.do(lambda: self._press_key(key))

    def _press_key(self, key: int) -> None:
        if self._inventory["keys"]:
            message = {"type": "INT32", "int_value": key}
            self.ask("publish", "~/keyboard/keypress", type="gazebo.msgs.Any", message=message)

    # Details ---------------------------------------------------------------------------------------------------------

    def _follow_model(self, state: ObservedState) -> None:
        number = self.view.ids.get(self._selected)
        if not self._follow or number is None:
            return
        here = self.view.pose(number, state)[:3]
        if not self._following:
            self._following = True
            for client in self.page.get_clients().values():
                client.camera.position = client.camera.position - here + self._offset
                client.camera.look_at = (0.0, 0.0, 0.0)
        self._offset = here.copy()
        self._root.position = -here

    def _drop_handle(self) -> None:
        if self._handle is not None:
            self._handle.remove()
            self._handle, self._held = None, False

    def _move_handle(self, state: ObservedState) -> None:
        """Show handles at the selected model, and keep them there while nobody holds them."""
        number = self.view.ids.get(self._selected)
        wanted = number is not None and hasattr(self.panel, "handles") and self.panel.handles.value
        if not wanted or number is None:
            self._drop_handle()
            return
        pose = self.view.pose(number, state)
        if self._handle is None:
            self._handle = self.page.scene.add_transform_controls(
                "/world/handles", scale=HANDLES, fixed=True, position=pose[:3], wxyz=pose[3:], depth_test=False
            )

            async def moved(event: Any) -> None:
                place, turn = np.array(event.target.position), np.array(event.target.wxyz)
                self.do(lambda: self._drag(event.phase, [*place.tolist(), *turn.tolist()]))

            self._handle.on_update(moved)
        elif not self._held:
            if not np.allclose(self._handle.position, pose[:3], atol=1e-5):
                self._handle.position = pose[:3]
            if not np.allclose(self._handle.wxyz, pose[3:], atol=1e-5):
                self._handle.wxyz = pose[3:]

    def _drag(self, phase: str, pose: list[float]) -> None:
        """A user moves the handles."""
        self._held = phase != "end"
        now = time.monotonic()
        if self._selected and (phase == "end" or (now >= self._next["move"] and "move" not in self._pending)):
            self._next["move"] = now + 0.05
            self.ask("move", name=self._selected, pose=pose)

    def _show_parts(self) -> None:
        """Sliders for what the driven robot carries."""
        robot = self.driver.robot if self.driver is not None else None
        number = self.view.ids.get(robot.entity) if robot is not None else None
        self.panel.set_parts("robot", self._interface_parts(number))

    def _interface_parts(self, number: int | None) -> list[Part]:
        """The sliders of the interfaces of an entity and of what it carries."""
        parts: list[Part] = []
        if number is None or self.controls is None or "interfaces" not in self._can:
            return parts
        for one in self.view.family(number):
            for served in self.view.entities[one]["interfaces"]:
                with contextlib.suppress(GazeboError):
                    if served["type"] in STEERED:
                        parts += interface_parts(self.controls.interface(served["type"], served["id"]))
        return parts

    def _show_model_parts(self) -> None:
        """Sliders for the joints, heads and lights of the selected model."""
        number, state = self.view.ids.get(self._selected), self._state
        parts: list[Part] = []
        if number is not None and state is not None:
            entity = self.view.entities[number]
            if "light" in self._can:
                parts += light_parts(entity, self.ask)
            if "joint" in self._can and self.view.scene["era"] == "classic":
                parts += joint_parts(entity, state, self.ask)
            parts += self._interface_parts(number)
        self.panel.set_parts("model", parts)

    def _show_rest(self, state: ObservedState, now: float) -> None:
        """Texts, images and whatever else is slower than the scene."""
        if now >= self._next["shadows"]:
            self.choose_shadows()
        if now >= self._next["status"]:
            self._next["status"] = now + STATUS_PERIOD
            self._show_status(state, now)
            self._show_info(state)
            if self._overlays is not None:
                self.panel.set_overlays(self._overlays())
        self._seek_on()
        if "seek" in self._can and now >= self._next["log"] and "status" not in self._pending:
            self._next["log"] = now + STATUS_PERIOD
            self._ask_log()
        if "contacts" in self.marks.on and now >= self._next["ask"] and "contacts" not in self._pending:
            self._next["ask"] = now + ASK_PERIOD
            self.ask("contacts", then=self._learn_contacts)
        if now >= self._next["image"]:
            self._next["image"] = now + IMAGE_PERIOD
            self._ask_readings()
            self._show_images(state)

    @property
    def _shows_images(self) -> bool:
        return bool(self.panel.live.value) or "frusta" in self.marks.on

    def _ask_readings(self) -> None:
        """Ask for images and ranges of SDF sensors, as far as they are shown."""
        kinds = {
            "camera": self._shows_images,
            "ray": "lasers" in self.marks.on,
            "gpu_ray": "lasers" in self.marks.on,
        }
        names = [
            sensor_name(entity, sensor)
            for entity in self.view.entities.values()
            for sensor in entity["sensors"]
            if kinds.get(sensor["kind"]) and "name" in sensor
        ]
        if names and "readings" in self._can:
            if "readings" not in self._pending:
                self.ask("readings", then=self._learn_readings, names=names)
        else:
            self._pictures = {}

    def _learn_readings(self, answer: Any) -> None:
        self.marks.ranges = answer["ranges"]
        self._pictures = {
            name: np.asarray(Image.open(io.BytesIO(base64.b64decode(data)))) for name, data in answer["images"].items()
        }

    def _ask_log(self) -> None:
        """Ask where the log is, unless it has to follow the user first; the server answers in the order of asking."""
        if self._wanted_time is None:
            slider = self.panel.log
            moves = slider.moves
            self.ask("status", then=lambda answer: slider.show(answer, moves))

    def _learn_contacts(self, answer: Any) -> None:
        self.marks.contacts = answer or []
        if self._state is not None:
            self.marks.show(self._state)

    def _show_status(self, state: ObservedState, now: float) -> None:
        if self._history and self._history[-1][2] > state.steps:
            self._history.clear()  # a reset, or back in time
        self._history.append((now, state.sim_time, state.steps))
        (begin, before, steps), span = self._history[0], now - self._history[0][0]
        factor = max(state.sim_time - before, 0.0) / span if span > 0.0 else 0.0
        rate = max(state.steps - steps, 0) / span if span > 0.0 else 0.0
        del begin
        self.panel.set_status(
            {
                "sim time": f"{state.sim_time:.2f} s",
                "real-time factor": f"{factor:.2f}",
                "steps": f"{rate:.0f} Hz",
                "state": "paused" if state.paused else "running",
            }
        )

    def _show_info(self, state: ObservedState) -> None:
        number = self.view.ids.get(self._selected)
        if number is None:
            self.panel.set_info([])
            return
        entity, pose = self.view.entities[number], self.view.pose(number, state)
        roll, pitch, yaw = _angles(pose[3:])
        rows = [
            ("id", self._selected),
            ("type", entity["type"] or entity["kind"]),
            ("position", f"{_numbers(pose[:3], 3)} m"),
            ("rotation", f"{_numbers(map(math.degrees, (roll, pitch, yaw)), 1)} deg"),
        ]
        row = self.view.rows.get(entity["body"], -1)
        if 0 <= row < len(state.bodies):
            linear, angular = state.bodies[row, 10:13], state.bodies[row, 13:16]
            rows.append(("velocity", f"{_numbers(linear, 2)} m/s"))
            rows.append(("angular velocity", f"{_numbers(angular, 2)} rad/s"))
        if self._details.get("mass"):
            rows.append(("mass", f"{self._details['mass']:.4g} kg"))
        if entity["interfaces"]:
            rows.append(("interfaces", ", ".join(f"{i['type']}.{i['id']}" for i in entity["interfaces"])))
        if self._details.get("plugins"):
            rows.append(("plugins", ", ".join(f"{name} ({file})" for name, file in self._details["plugins"])))
        if entity["sensors"]:
            rows.append(("sensors", ", ".join(str(s.get("name") or s["kind"]) for s in entity["sensors"])))
        rows.append(("bodies", ", ".join(body["name"] or "-" for body in entity["bodies"][:30])))
        if entity["joints"]:
            rows.append(("joints", ", ".join(joint["name"] or joint["kind"] for joint in entity["joints"][:30])))
        if entity["parent"] in self.view.entities:
            rows.append(("attached to", self.view.entities[entity["parent"]]["id"]))
        below = [self.view.entities[n]["id"] for n in self.view.family(number)[1:]]
        if below:
            rows.append(("carries", ", ".join(below)))
        self.panel.set_info(rows)

    def _show_images(self, state: ObservedState) -> None:
        images: dict[str, NDArray[np.uint8]] = {}
        names = [
            (one["type"], one["id"])
            for entity in self.view.entities.values()
            for one in entity["interfaces"]
            if one["type"] in ("camera", "guicam")
        ]
        if self._shows_images and self.controls is not None:
            for kind, name in names:
                with contextlib.suppress(GazeboError, ClosedError):
                    image = np.array(self.controls.interface(kind, name).image)
                    if image.size:
                        images[name] = image
            images |= self._pictures
        former = self.marks.images
        # The same object stands for the same image, which is not sent again.
        images = {name: former[name] if _same(former.get(name), image) else image for name, image in images.items()}
        self.marks.images = images
        if "frusta" in self.marks.on and any(former.get(name) is not image for name, image in images.items()):
            self.marks.show(state)
        self.panel.set_images(images if self.panel.live.value else {})


def _same(a: NDArray[Any] | None, b: NDArray[Any]) -> bool:
    return a is not None and (a is b or np.array_equal(a, b))


def _around(boxes: list[NDArray[Any]]) -> tuple[NDArray[Any], float] | None:
    """Middle and size [m] of the box around boxes; None if there are none."""
    if not boxes:
        return None
    low, high = np.min([box[0] for box in boxes], axis=0), np.max([box[1] for box in boxes], axis=0)
    return (low + high) / 2.0, max(float(np.linalg.norm(high - low)), 0.6)


def _numbers(values: Iterable[float], digits: int) -> str:
    """Numbers as a text, without minus signs before zeros."""
    return " ".join(f"{round(float(value), digits) + 0.0:.{digits}f}" for value in values)


def _angles(q: NDArray[Any]) -> tuple[float, float, float]:
    """Roll, pitch and yaw [rad] of a quaternion (u, x, y, z)."""
    u, x, y, z = (float(part) for part in q)
    roll = math.atan2(2.0 * (u * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    pitch = math.asin(min(max(2.0 * (u * y - z * x), -1.0), 1.0))
    return roll, pitch, math.atan2(2.0 * (u * z + x * y), 1.0 - 2.0 * (y * y + z * z))
