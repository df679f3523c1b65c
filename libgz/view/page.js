// The page's own part: keys and a stick to drive with. Everything else of the page is viser's.
(() => {
  "use strict";
  // The address stays as it was opened: without the address of the socket that viser would add.
  const replace = history.replaceState.bind(history);
  history.replaceState = (state, title, url) => {
    if (typeof url !== "string" || !url.includes("websocket=")) replace(state, title, url);
  };
  // viser connects only where the user's focus is: an embedded page, and one beside a terminal, shall connect, too.
  document.hasFocus = () => !document.hidden;
  document.addEventListener("visibilitychange", () => { if (!document.hidden) window.dispatchEvent(new Event("focus")); });
  if (!window.libgzControl) return;

  const LONGEST = 200; // [ms] between two notes while something is held
  const WAYS = {
    KeyW: [1, 0, 0], ArrowUp: [1, 0, 0], KeyS: [-1, 0, 0], ArrowDown: [-1, 0, 0],
    KeyA: [0, 1, 0], ArrowLeft: [0, 1, 0], KeyD: [0, -1, 0], ArrowRight: [0, -1, 0],
    KeyR: [0, 0, 1], KeyF: [0, 0, -1],
  };
  const held = new Set();
  let socket = null, driving = false, stick = null, lean = [0, 0], timer = null, pad = null, knob = null, sent = "";

  const report = (note) => {
    if (socket && socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify(note));
  };
  const wanted = () => {
    const sum = [lean[0], lean[1], 0];
    for (const code of held) WAYS[code].forEach((part, i) => { sum[i] += part; });
    return sum.map((part) => Math.max(-1, Math.min(1, part)));
  };
  const drive = () => {
    const way = wanted(), still = way.every((part) => part === 0);
    if (!still || sent !== "still") report({ drive: way });
    sent = still ? "still" : "moving";
    clearTimeout(timer);
    timer = still ? null : setTimeout(drive, LONGEST);
  };
  const release = () => { held.clear(); drive(); };

  const typing = (target) =>
    target instanceof HTMLElement &&
    (target.isContentEditable || target.tagName === "TEXTAREA" || target.tagName === "SELECT" ||
      (target.tagName === "INPUT" && !["checkbox", "radio", "button"].includes(target.type)) ||
      target.getAttribute("role") === "slider");
  const onKey = (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || typing(event.target)) return;
    const down = event.type === "keydown";
    if (down && !event.repeat) report({ key: event.key.length === 1 ? event.key.charCodeAt(0) : event.keyCode });
    if (!(event.code in WAYS) || (!driving && !held.has(event.code))) return;
    event.preventDefault();
    event.stopImmediatePropagation();
    if (down ? held.has(event.code) : !held.has(event.code)) return;
    if (down) held.add(event.code); else held.delete(event.code);
    drive();
  };
  for (const type of ["keydown", "keyup"]) window.addEventListener(type, onKey, true);
  window.addEventListener("blur", release);
  document.addEventListener("visibilitychange", () => { if (document.hidden) release(); });

  const build = () => {
    pad = document.createElement("div");
    pad.id = "libgz-stick";
    pad.title = "drive: drag, or W A S D and arrow keys";
    pad.style.cssText =
      "position:fixed;left:18px;bottom:92px;width:104px;height:104px;border-radius:50%;z-index:5;touch-action:none;" +
      "background:rgba(255,255,255,.35);border:2px solid rgba(40,60,90,.45);cursor:grab;display:none";
    knob = document.createElement("div");
    knob.style.cssText =
      "position:absolute;left:32px;top:32px;width:36px;height:36px;border-radius:50%;background:rgba(34,110,200,.85);" +
      "pointer-events:none";
    pad.appendChild(knob);
    const set = (x, y) => {
      lean = [-y, -x];
      knob.style.transform = `translate(${x * 34}px,${y * 34}px)`;
      drive();
    };
    const follow = (event) => {
      const box = pad.getBoundingClientRect();
      let x = (event.clientX - box.left - box.width / 2) / 42, y = (event.clientY - box.top - box.height / 2) / 42;
      const length = Math.hypot(x, y);
      if (length > 1) { x /= length; y /= length; }
      set(x, y);
    };
    pad.addEventListener("pointerdown", (event) => { stick = event.pointerId; pad.setPointerCapture(stick); follow(event); });
    pad.addEventListener("pointermove", (event) => { if (event.pointerId === stick) follow(event); });
    for (const type of ["pointerup", "pointercancel"]) {
      pad.addEventListener(type, () => { stick = null; set(0, 0); });
    }
    document.body.appendChild(pad);
  };
  const learn = (facts) => {
    driving = Boolean(facts.driving);
    if (typeof facts.title === "string") document.title = facts.title;
    if (!pad && document.body) build();
    if (pad) pad.style.display = driving ? "block" : "none";
    if (!driving) release();
  };
  const connect = () => {
    const path = location.pathname.replace(/\/+$/, "");
    socket = new WebSocket(`${location.protocol === "https:" ? "wss" : "ws"}://${location.host}${path}/notes`);
    socket.onmessage = (event) => learn(JSON.parse(event.data));
    socket.onclose = () => { learn({}); setTimeout(connect, 1000); };
  };
  if (document.body) connect(); else window.addEventListener("DOMContentLoaded", connect);
})();
