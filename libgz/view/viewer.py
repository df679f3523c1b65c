"""Viewer: shows a running world in browsers, and passes on what their users do."""

from __future__ import annotations

import contextlib
import json
import logging
import queue
import re
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from libgz.base.closing import Closing
from libgz.base.errors import GazeboError, InterfaceError, ParameterError, ServerGoneError
from libgz.base.numbers import whole_number
from libgz.simulation.repeated import MOST_LINES, repeated
from libgz.transport.observer import ObservedState
from libgz.transport.tally import Tally
from libgz.view.assets import Assets
from libgz.view.channels import Channels
from libgz.view.controllers import Controllers
from libgz.view.driving import Driver, Robot, robots_of
from libgz.view.fields import fields_of_interface
from libgz.view.gate import Gate
from libgz.view.pages import Page, Pages
from libgz.view.parts import STEERED, interface_parts
from libgz.view.portraits import Portraits
from libgz.view.protocol import CHANNELS, VERBS, scene_message, state_message, wanted_names
from libgz.view.source import Controls, Overlay, Source

__all__ = ["HOST", "PORT", "RATE", "Viewer"]

log = logging.getLogger("libgz.view")

HOST, PORT, RATE = "127.0.0.1", 8080, 30.0
SKINS = ("fine", "plain")
LONGEST_LOOK = 0.01  # [s] at what pages that only watch have sent, per frame
LOG_PERIOD, RETRY = 0.25, 0.5  # [s]
MOST_AT_ONCE = 20  # pages that only watch and get a state at the same time
ALONE_PERIOD = 0.5  # [s] between two frames while nobody watches
LARGEST_SHARE = 0.4  # of a core that frames may take; beyond that there are fewer
MOST_REQUESTS, MOST_OF_WATCHERS = 50, 10  # of all pages that have not been answered, when another one comes
LARGEST_REQUESTS = 128 << 20  # [byte] of all requests that have not been answered, with what a parser made of them
MOST_HELD, LONGEST_NAME = 16, 1000  # models that a page holds; characters of a name
FASTEST = 10.0  # [m/s], [rad/s] of a driven robot
READS = frozenset({"describe", "catalogue", "attributes", "history", "diff"})  # requests of pages that only watch, too
# What pages offer because of it.
CAN_SHOW = frozenset({"interfaces", "publish", "contacts", "readings", "problems", "portrait", "probes"})
# What a text that a page inserts may not have: it would run code, expand macros, or hide one of both.
CODE = re.compile(r"plugin|xacro|<!", re.IGNORECASE)
ENDED = "The server has ended. Waiting for the next one ..."
WATCHING = "This address has no valid token."


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
        skins: of the robots of worldfiles when a page opens, "fine" or "plain" ones, as cameras serve them.

    Attributes:
        failures: how many frames and actions ended with an error that is none of libgz.
        scene: that is shown.
        asset_names: the addresses of its assets.

    Raises:
        GazeboError: no port is free.
        ParameterError: there are no such skins.
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
        skins: str = SKINS[0],
    ) -> None:
        if skins not in SKINS:
            raise ParameterError(f"skins is {skins!r}; allowed are {' and '.join(SKINS)}")
        self._skins = skins
        self._wait, self.failures = wait, 0
        self.source, self.controls, self.rate = source, controls, rate
        self._overlays = overlays
        self._actions: queue.SimpleQueue[Callable[[], object]] = queue.SimpleQueue()
        self._watchers: queue.SimpleQueue[Callable[[], object]] = queue.SimpleQueue()  # what only watching pages send
        self._asking = ThreadPoolExecutor(1, "viewer")
        self._requests, self._requested = 0, 0  # of pages that have not been answered, and bytes of them
        self._requests_lock = threading.Lock()
        self._controller: Page | None = None  # the page that controlled in the last frame
        self._held: dict[str, None] = {}  # what it holds
        self._can: frozenset[str] = controls.abilities if controls is not None else frozenset()
        self.driver = self._new_driver()
        self._robots: dict[str, Robot] = {}
        self._inventory: dict[str, Any] = {"drives": [], "keys": False}
        self.scene: dict[str, Any] = {}
        self.asset_names: frozenset[str] = frozenset()
        self._scene_message, self._state_message = b"", b""
        self._state: ObservedState | None = None
        self._revision = -1
        self._log: dict[str, Any] | None = None
        self._next_log = self._next_try = 0.0
        self._status = ""
        self._due = self._shown = 0.0
        self._behind: dict[Page, bool] = {}  # whether they lack the present state; first who got one longest ago
        self._tally = Tally(MOST_LINES)
        self._gone = False
        self._ended = threading.Event()
        self.assets = Assets(source)
        self.controllers = Controllers()
        self._portraits = Portraits(self._portrait_text)
        self._gate = Gate(host, self.assets, self._portraits, token)
        self._pages = Pages(
            self._gate,
            port,
            lambda page: self.do(lambda: self._welcome(page)),
            self.hear,
            lambda page: self.do(lambda: self._leave(page)),
        )
        self.channels = Channels(self._pages, self._ask, overlays)

    def _queue(self, page: Page) -> queue.SimpleQueue[Callable[[], object]]:
        return self._actions if page.may_control else self._watchers

    def _new_driver(self) -> Driver | None:
        return Driver(self.controls) if self.controls is not None and self._can & {"interfaces", "publish"} else None

    @property
    def url(self) -> str:
        """The address of the page that can control."""
        return f"{self.watch_url}?token={self._gate.token}"

    def url_for_once(self) -> str:
        """A new address of the page that can control, for the first that asks for it: to be opened in a browser."""
        return f"{self.watch_url}?token={self._gate.word_for_once()}"

    @property
    def watch_url(self) -> str:
        """The address of the page that only watches."""
        host = {"0.0.0.0": "127.0.0.1", "::": "[::1]"}.get(self._gate.host, self._gate.host)
        return f"http://{f'[{host}]' if ':' in host and host[0] != '[' else host}:{self._pages.port}/"

    @property
    def pages(self) -> int:
        """How many pages are connected."""
        return len(self._pages)

    def close(self) -> None:
        """End the page. Can be called twice."""
        if self._ended.is_set():
            return
        self._ended.set()
        if self.driver is not None:
            with contextlib.suppress(GazeboError):
                self.driver.choose(None)
        self._asking.shutdown(wait=False, cancel_futures=True)
        self._pages.close()
        self._portraits.close()

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
        begin, used = time.monotonic(), time.thread_time()
        self.act()
        if begin < self._due:
            return
        if len(self._pages) or begin >= self._shown + ALONE_PERIOD or self._state is None:
            self._shown = begin
            self._attempt(self.frame)
        now, used = time.monotonic(), time.thread_time() - used
        self._due = max(self._due + 1.0 / self.rate, begin + used / LARGEST_SHARE, now)

    def act(self) -> None:
        """Do what users did since the last frame; what is refused is shown to them."""
        end = time.monotonic() + LONGEST_LOOK
        for actions in (self._actions, self._watchers):
            for _ in range(actions.qsize()):  # what comes meanwhile waits for the next frame
                if actions is self._watchers and time.monotonic() > end:
                    break
                self._attempt(actions.get())
        self.controllers.act()
        self._attempt(self._follow_control)
        if self.driver is not None:
            self._attempt(self.driver.act)

    def _follow_control(self) -> None:
        """Release what a page held, and stop what it drove, once it does not control any more."""
        former = self._controller
        if former is self.controllers.page:
            return
        self._controller, held, self._held = self.controllers.page, self._held, {}
        if former is not None and self.driver is not None:
            self.driver.leave(former.number)
        for name in held:
            self._ask("hold", lambda _answer: None, "off", name=name)

    def _attempt(self, action: Callable[[], object]) -> None:
        """Call an action. The viewer survives what it raises: pages close at any moment, and send what they like."""
        with repeated(self._tally):
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
        self._post("problem", json.dumps({"problem": {"text": text[:500], "level": "error"}}))

    def _post(self, key: str, message: bytes | str) -> None:
        self._pages.post(self._pages, key, message)

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
            changed = self._state is None or (state.number, state.paused) != (self._state.number, self._state.paused)
            self._state = state
        except ServerGoneError:
            self._lose()
            return
        except InterfaceError as error:
            self._show_status(str(error), "waiting")
            return
        if changed:
            self._state_message = state_message(state)
        self._pages.post(self._in_turn(changed), "state", self._state_message)
        if "seek" in self._can and now >= self._next_log and "status" not in self.channels.pending:
            self._next_log = now + LOG_PERIOD
            self._ask("status", self._learn_log)
        self._show_status("", "")
        self.channels.show(now, state.sim_time, self.controls, self._can, self.scene)

    def _in_turn(self, changed: bool) -> list[Page]:
        """The pages that get the present state: of many that only watch, those first that have waited for longest."""
        seen = [page for page in self._pages if page.visible]
        behind = {page: changed or lacks for page, lacks in self._behind.items() if page in seen}
        behind |= {page: changed for page in seen if page not in behind}
        lacking = [page for page, lacks in behind.items() if lacks]
        watching = [page for page in lacking if not page.may_control]
        chosen = [*(page for page in lacking if page.may_control), *watching[:MOST_AT_ONCE]]
        others = {page: lacks for page, lacks in behind.items() if page not in chosen}
        self._behind = others | dict.fromkeys(chosen, False)
        return chosen

    def _show_scene(self, state: ObservedState) -> ObservedState:
        """Show the scene that belongs to the present state, which is returned."""
        for _ in range(100):
            scene = self.source.scene
            if scene["revision"] == state.revision:
                break
            state = self.source.state()
        self.scene, self._revision = scene, state.revision
        addresses = self.assets.of_scene(scene)
        self.asset_names = frozenset(filter(None, addresses.values()))
        self._scene_message = scene_message(scene, addresses)
        self._post("scene", self._scene_message)
        self._state = None  # what follows is a state of this scene
        self._list_robots()
        if "inventory" in self._can:
            self._ask("inventory", self._learn_inventory)
        for page in self._pages:
            self._hail(page)
        return state

    def show_to(self, page: Any) -> None:
        """Show all to what is like a page, such as a recorder."""
        self._pages.join(page)

    def open(self, page: Any) -> None:
        """A page of another channel than the port is opened; safe in every thread."""
        self._pages.join(page)
        self.do(lambda: self._welcome(page))

    def hear(self, page: Any, message: dict[str, Any], size: int) -> None:
        """Do what a page wants by a message that takes so many bytes, between two frames; safe in every thread."""
        self._queue(page).put(lambda: self._obey(page, message, size))

    def leave(self, page: Any) -> None:
        """A page that was opened by `open` is closed; safe in every thread."""
        self._pages.part(page)
        self.do(lambda: self._leave(page))

    # Coming and going ------------------------------------------------------------------------------------------------

    def _hail(self, page: Page) -> None:
        own = {"fields", "parts", "steer"} if "interfaces" in self._can else set()
        mine = sorted((self._can & (VERBS | CAN_SHOW)) | own | ({"press"} if self._overlays is not None else set()))
        hello: dict[str, Any] = {"title": self._title(), "abilities": mine, "skins": self._skins}
        if not page.may_control:
            hello["reason"] = WATCHING
        elif self.controls is None or not self._can:
            hello["reason"] = "This viewer only shows the world."
        page.post("hello", json.dumps({"hello": hello, "control": self.controllers.state_of(page)}))

    def _title(self) -> str:
        """Of the page: the world's name, or that of its file where the world has no name of its own."""
        name, file = str(self.scene.get("world", "")), str(self.scene.get("file", ""))
        return f"{Path(file).stem if file and name == 'default' else name} - libgz"

    def _welcome(self, page: Page) -> None:
        """Greet a page that was opened."""
        if self.controls is not None:
            self.controllers.open(page)
        self._hail(page)
        page.post("status", self._status or json.dumps({"status": {"text": "", "level": ""}}))
        page.post("robots", self._robots_message())
        if self._scene_message:
            page.post("scene", self._scene_message)
            page.post("state", self._state_message)

    def _leave(self, page: Page) -> None:
        """A page was closed."""
        if self.driver is not None:
            self.driver.leave(page.number)
        self.controllers.close(page)

    def _lose(self) -> None:
        """The server has ended."""
        self._gone = True
        self._show_status(ENDED, "ended")
        if self.controls is not None:
            self.controls.reconnect()

    def _come_back(self, now: float) -> None:
        if now < self._next_try:
            return
        self._next_try = now + RETRY
        try:
            self.source.reconnect()
        except (ServerGoneError, InterfaceError):
            return
        self._gone, self._revision, self._state = False, -1, None
        self._robots, self._log = {}, None
        self.assets.clear()
        self.channels.clear()
        self.channels.pending.clear()
        if self.controls is not None:
            self._can = self.controls.abilities
            self.driver = self._new_driver()
        self._inventory = {"drives": [], "keys": False}

    def _show_status(self, text: str, level: str) -> None:
        status = json.dumps({"status": {"text": text, "level": level}, "log": self._log})
        if status != self._status:
            self._status = status
            self._post("status", status)

    def _learn_log(self, answer: Any) -> None:
        self._log = {name: float(answer[name]) for name in ("begin", "end", "time")} if answer else None

    # Requests --------------------------------------------------------------------------------------------------------

    def _ask(self, verb: str, then: Callable[[Any], object], argument: str = "-", **content: Any) -> None:
        """Send a request of the viewer's own to the server; `then` is called with the answer, between two frames."""
        controls = self.controls
        if controls is None:
            return

        def work() -> None:
            try:
                answer = controls.ask(verb, argument, **content)
                self.do(lambda: then(answer))
            except GazeboError as error:
                log.debug("%s: %s", verb, error)  # the page asked for nothing
            finally:
                self.channels.pending.discard(verb)

        self.channels.pending.add(verb)
        self._submit(work)

    def _submit(self, work: Callable[[], None]) -> None:
        if self._wait:
            work()
            self.act()
            return
        with contextlib.suppress(RuntimeError):  # the viewer is closed
            self._asking.submit(work)

    def _portrait_text(self, model: str) -> str | None:
        """What a portrait of a model of the catalogue is made of; in the thread that makes it."""
        if self.controls is None or "portrait" not in self._can:
            return None
        return str(self.controls.ask("portrait", model=model)["text"])

    def _obey(self, page: Page, message: dict[str, Any], size: int) -> None:
        """A message of a page."""
        page.acted()
        if "want" in message:
            channel = message["want"]
            if channel in CHANNELS:
                page.wants[channel] = wanted_names(message)
                self.channels.welcome(page, channel)
        elif "visible" in message:
            page.visible = message["visible"] is True
            if page.visible and self._state_message:
                page.post("state", self._state_message)
            elif self.driver is not None:
                self.driver.leave(page.number)
        elif "ask" in message:
            number = message.get("number")
            if isinstance(number, int):
                self._answer(page, number, message, size)
        elif page is self.controllers.page:
            self._steer(page, message)

    def _answer(self, page: Page, number: int, message: dict[str, Any], size: int) -> None:
        """Answer a request of a page."""

        def reply(**result: Any) -> None:
            page.post(f"answer {number}", json.dumps({"answer": number, **result}))

        verb, argument, content = message["ask"], message.get("argument", "-"), message.get("content") or {}
        try:
            if not isinstance(verb, str) or not isinstance(argument, str) or not isinstance(content, dict):
                raise GazeboError("a request has a verb and an argument, which are texts, and a content")
            if verb == "control":
                self.controllers.request(page, argument)
                reply(value=None)
                return
            if verb == "fields":
                reply(value=self._fields(argument))
                return
            if page is not self.controllers.page and verb not in READS:
                raise GazeboError("this page does not control the world")
            own = {"parts": self._list_parts, "steer": self._move_part, "press": self._press}.get(verb)
            if own is not None:
                reply(value=own(argument, content))
                return
            if verb not in VERBS or verb not in self._can:
                raise GazeboError(f"there is no request {verb[:50]!r} here")
            if any(ord(letter) < 33 for letter in argument) or len(argument) > 200 or not argument:
                raise GazeboError(f"the argument of {verb} is not one word")
            self._pass_on(page, verb, argument, content, size, reply)
        except GazeboError as error:
            reply(error=str(error)[:1000])

    def _pass_on(
        self, page: Page, verb: str, argument: str, content: dict[str, Any], size: int, reply: Callable[..., None]
    ) -> None:
        """Send a request of a page to the server."""
        controls = self.controls
        most = MOST_REQUESTS if page is self.controllers.page else MOST_OF_WATCHERS
        with self._requests_lock:
            if controls is None or self._requests >= most or self._requested + size > LARGEST_REQUESTS:
                raise GazeboError("the server has not answered the requests before; try again later")
            self._requests, self._requested = self._requests + 1, self._requested + size
        if verb == "write":
            content = {}  # pages name no files
        if verb == "hold":
            name = str(content.get("name", ""))[:LONGEST_NAME]
            self._held.pop(name, None)
            if argument == "on":
                self._held[name] = None
                for oldest in [*self._held][:-MOST_HELD]:
                    del self._held[oldest]

        def work() -> None:
            try:
                if verb == "insert":
                    _check_insertion(content, controls)
                reply(value=controls.ask(verb, argument, **content))
            except GazeboError as error:
                reply(error=str(error)[:1000])
            except Exception:
                self.failures += 1
                with repeated(self._tally):
                    log.exception("the viewer continues after an error of request %s", verb)
                reply(error=f"request {verb} failed; the viewer's log says why")
            finally:
                with self._requests_lock:
                    self._requests, self._requested = self._requests - 1, self._requested - size

        self._submit(work)

    # What users do ---------------------------------------------------------------------------------------------------

    def _steer(self, page: Page, message: dict[str, Any]) -> None:
        """What the page that controls does without asking for an answer."""
        driver = self.driver
        if "key" in message and isinstance(message["key"], int):
            self._press_key(message["key"])
        elif driver is None:
            return
        elif "drive" in message:
            driver.want(page.number, message["drive"])
        elif "robot" in message:
            driver.choose(self._robots.get(str(message["robot"])))
            self._post("robots", self._robots_message())
        elif isinstance(message.get("speeds"), dict):
            speeds = {
                name: min(max(float(value), 0.0), FASTEST)
                for name, value in message["speeds"].items()
                if isinstance(value, int | float)
            }
            driver.speed, driver.turn = speeds.get("linear", driver.speed), speeds.get("angular", driver.turn)
            self._post("robots", self._robots_message())

    def _press_key(self, key: int) -> None:
        if self._inventory["keys"] and "publish" in self._can:
            message = {"type": "INT32", "int_value": key}
            content = {"type": "gazebo.msgs.Any", "message": message}
            controls = self.controls
            self._submit(lambda: controls.ask("publish", "~/keyboard/keypress", **content) if controls else None)

    def _learn_inventory(self, answer: Any) -> None:
        self._inventory = answer or self._inventory
        self._list_robots()

    def _list_robots(self) -> None:
        if self.driver is None:
            return
        robots = {robot.label: robot for robot in robots_of(self.scene, self._inventory["drives"])}
        if robots != self._robots:
            had, self._robots = set(self._robots), robots
            present = self.driver.robot
            if (present is None and not had) or (present is not None and present.label not in robots):
                self.driver.choose(next(iter(robots.values()), None))
        self._post("robots", self._robots_message())

    def _robots_message(self) -> str:
        driver = self.driver
        found = [
            {"label": one.label, "entity": one.entity, "kind": "position" if one.interface else "vel_cmd"}
            for one in self._robots.values()
        ]
        robot = driver.robot.label if driver is not None and driver.robot is not None else ""
        speeds = {"linear": driver.speed, "angular": driver.turn} if driver is not None else {}
        return json.dumps({"robots": {"list": found, "robot": robot, "speeds": speeds}})

    # Interfaces ------------------------------------------------------------------------------------------------------

    def _interfaces(self, name: str) -> Iterator[Any]:
        """The interfaces of an entity, by its id, and of what is attached to it."""
        entities = {entity["number"]: entity for entity in self.scene.get("entities", ())}
        family = [number for number, entity in entities.items() if entity["id"] == name][:1]
        for one in family:
            family += [n for n, entity in entities.items() if entity["parent"] == one and n not in family]
        if self.controls is None or "interfaces" not in self._can:
            return
        for number in family:
            for served in entities[number]["interfaces"]:
                with contextlib.suppress(GazeboError):
                    yield self.controls.interface(served["type"], served["id"])

    def _fields(self, name: str) -> list[dict[str, Any]]:
        """The numbers that the interfaces of an entity hold."""
        return [field for interface in self._interfaces(name) for field in fields_of_interface(interface)][:2000]

    def _list_parts(self, name: str, _content: dict[str, Any]) -> list[dict[str, Any]]:
        """The sliders and buttons of what an entity carries."""
        found = []
        for interface in self._interfaces(name):
            if interface.type in STEERED:
                for i, part in enumerate(interface_parts(interface)):
                    found.append(part.as_data(f"{interface.type}.{interface.id}/{i}"))
        return found

    def _move_part(self, key: str, content: dict[str, Any]) -> None:
        """Move a part."""
        name, _, place = key.rpartition("/")
        kind, _, owner = name.partition(".")
        value = content.get("value", 1)
        if self.controls is None or kind not in STEERED or not isinstance(value, int | float):
            raise GazeboError(f"there is no part {key[:100]!r}")
        parts = interface_parts(self.controls.interface(kind, owner))
        number = whole_number(place, len(parts) - 1)
        if number is None:
            raise GazeboError(f"there is no part {key[:100]!r}")
        part = parts[number]
        low, high = part.limits or (value, value)
        part.action(min(max(float(value), low), high))

    def _press(self, name: str, content: dict[str, Any]) -> None:
        """Press a button of a GUI plugin."""
        overlay = self._overlays().get(name) if self._overlays is not None else None
        label = content.get("label")
        if overlay is None or label not in overlay.Buttons():
            raise GazeboError(f"there is no button {label!r} of {name!r}")
        overlay.Press(label)


def _check_insertion(content: dict[str, Any], controls: Controls) -> None:
    """Refuse what a page inserts if it is no model of the catalogue, or could run code; mark a text that it wrote.

    Raises:
        GazeboError: it is refused.
    """
    text = content.get("text")
    if text:  # an empty one is none: the model's name counts
        if not isinstance(text, str) or CODE.search(text.removeprefix("<?xml")):
            raise GazeboError("a page inserts no plugins, macros or declarations: put the model into a world's file")
        content["of_page"] = True  # what it includes is checked where it is read
        return
    entries = controls.ask("catalogue") or []
    if content.get("model") not in [one["name"] if isinstance(one, dict) else one for one in entries]:
        raise GazeboError(f"there is no {str(content.get('model'))[:100]!r} in the catalogue")
