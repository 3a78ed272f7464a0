// The dialog in which a scene turns: drag or arrow keys turn it, wheel, two fingers, + and - come nearer.
const table = document.getElementById("turntable");
if (table) {
  const canvas = table.querySelector("canvas"), turning = table.querySelector(".turning"), message = table.querySelector("p");
  const doors = table.querySelector("input[type=range]"), download = table.querySelector("a");
  const state = { azimuth: 0, elevation: 0.4, distance: 4, draw: null, gl: null, turns: false, asked: 0 };
  const fingers = new Map();

  const show = () => {
    if (!state.draw || !table.open) return;
    const ratio = Math.min(devicePixelRatio, 2);
    [canvas.width, canvas.height] = [Math.round(canvas.clientWidth * ratio), Math.round(canvas.clientHeight * ratio)];
    const { azimuth: a, elevation: e, distance: d, target } = state;
    const eye = [target[0] + d * Math.cos(e) * Math.cos(a), target[1] + d * Math.sin(e), target[2] + d * Math.cos(e) * Math.sin(a)];
    state.draw(eye, target, doors.value / 100);
  };
  const later = () => { state.asked ||= requestAnimationFrame(() => { state.asked = 0; show(); }); };
  const turn = (right, up, nearer = 1) => {
    state.azimuth += right;
    state.elevation = Math.min(1.5, Math.max(0.04, state.elevation + up));
    state.distance = Math.min(state.farthest, Math.max(0.6, state.distance * nearer));
    later();
  };
  const spin = (on) => {
    state.turns = on;
    turning.ariaPressed = String(on);
    turning.textContent = on ? "Stop turning" : "Turn";
    let before = performance.now();
    const step = (now) => {
      if (!state.turns || !table.open) return;
      state.azimuth += (now - before) / 6000;
      before = now;
      show();
      requestAnimationFrame(step);
    };
    if (on) requestAnimationFrame(step);
  };

  const open = async (button) => {
    const held = document.getElementById(button.dataset.scene).textContent.trim();
    const packed = Uint8Array.from(atob(held), (letter) => letter.charCodeAt(0));
    const bytes = await new Response(new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"))).arrayBuffer();
    URL.revokeObjectURL(download.href);
    download.href = URL.createObjectURL(new Blob([bytes], { type: "model/gltf-binary" }));
    download.download = `${button.dataset.scene}.glb`;
    state.gl ??= canvas.getContext("webgl2", { antialias: true, preserveDrawingBuffer: true });
    table.showModal();
    message.hidden = Boolean(state.gl);
    message.textContent = state.gl ? "" : "This browser shows no WebGL 2; the scene can be saved and opened elsewhere.";
    if (!state.gl) return;
    const scene = await readScene(bytes);
    const eye = scene.eye.slice(12, 15), ahead = scene.eye.slice(8, 11).map((value) => -value);
    const along = Math.max(1, dot(minus(scene.center, eye), ahead)); // the furniture's middle, as deep as the camera looks
    state.target = eye.map((value, i) => value + along * ahead[i]);
    const back = minus(eye, state.target);
    state.distance = Math.hypot(...back);
    state.farthest = 3 * Math.max(state.distance, scene.radius);
    state.azimuth = Math.atan2(back[2], back[0]);
    state.elevation = Math.asin(back[1] / state.distance);
    state.draw = rendererOf(state.gl, scene);
    doors.value = 0;
    doors.closest("label").hidden = !scene.nodes.some((node) => node.extras.joint);
    show();
    spin(!matchMedia("(prefers-reduced-motion: reduce)").matches);
    canvas.focus();
  };
  for (const button of document.querySelectorAll("button.turn")) button.addEventListener("click", () => open(button));

  turning.addEventListener("click", () => spin(!state.turns));
  doors.addEventListener("input", later);
  table.querySelector(".close").addEventListener("click", () => table.close());
  canvas.addEventListener("pointerdown", (event) => {
    spin(false);
    canvas.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, event);
  });
  const apart = () => { const [a, b] = fingers.values(); return Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY); };
  canvas.addEventListener("pointermove", (event) => {
    const before = fingers.get(event.pointerId);
    if (!before) return;
    const gap = fingers.size === 2 ? apart() : 0;
    fingers.set(event.pointerId, event);
    if (gap) turn(0, 0, gap / Math.max(apart(), 1));
    else if (fingers.size === 1) turn((event.clientX - before.clientX) / 180, (event.clientY - before.clientY) / 180);
  });
  for (const kind of ["pointerup", "pointercancel"]) canvas.addEventListener(kind, (event) => fingers.delete(event.pointerId));
  canvas.addEventListener("wheel", (event) => { event.preventDefault(); turn(0, 0, Math.exp(event.deltaY / 800)); }, { passive: false });
  const KEYS = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1], "+": [0, 0, 0.9], "-": [0, 0, 1.1] };
  canvas.addEventListener("keydown", (event) => {
    if (!(event.key in KEYS)) return;
    event.preventDefault();
    spin(false);
    turn(...KEYS[event.key]);
  });
  addEventListener("resize", later);
}
