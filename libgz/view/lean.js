// Changes defaults of viser's client before it runs, so that a page shows its world sooner; in live pages and in replays.
(() => {
  "use strict";
  const isSoftware = () => {
    const gl = document.createElement("canvas").getContext("webgl2");
    const info = gl && gl.getExtension("WEBGL_debug_renderer_info");
    const name = info ? String(gl.getParameter(info.UNMASKED_RENDERER_WEBGL)) : "";
    if (gl) gl.getExtension("WEBGL_lose_context")?.loseContext();
    return /swiftshader|llvmpipe|softpipe|software/i.test(name);
  };
  // Lights and an environment map of its own, which the scene's replace: they cost more time than the scene.
  const changes = [
    [
      /enableDefaultLights:!0,enableDefaultLightsShadows:!0,environmentMap:null/,
      "enableDefaultLights:!1,enableDefaultLightsShadows:!1,environmentMap:{hdri_data:null}",
    ],
  ];
  const slow = [
    [/antialias:!0,alpha:!0/, "antialias:!1,alpha:!0"],
    [/cascades:(\w+)=3,/, "cascades:$1=1,"], // each is a light and a shadow map
    [/(id:`webgl-software-rendering`[^{}]*)autoClose:!1/, "$1autoClose:6e3"], // it covers the scene
  ];
  const replayed = [
    [/shadows:`percentage`/, "shadows:!1"], // nobody could switch them off
    [/1e3\/120/, "1e3/20"], // [ms] between two moments
  ];
  const append = Node.prototype.appendChild;
  Node.prototype.appendChild = function (child) {
    if (child instanceof HTMLScriptElement && child.type === "module") {
      Node.prototype.appendChild = append; // the client is one script
      const software = isSoftware(), replay = window.__VISER_EMBED_DATA__ !== undefined;
      const wanted = [...changes, ...(software ? slow : []), ...(software && replay ? replayed : [])];
      let text = child.textContent, found = 0;
      for (const [what, other] of wanted) {
        const changed = text.replace(what, other);
        found += changed !== text;
        text = changed;
      }
      child.textContent = text;
      window.libgzChanges = [found, wanted.length];
    }
    return append.call(this, child);
  };
})();
