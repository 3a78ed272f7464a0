// The dialog in which a scene turns, with three.js: drag or arrow keys turn it, wheel, two fingers, + and - come nearer.
// Nothing is loaded before somebody presses a button.
const table = document.getElementById("turntable");
if (table) {
  const canvas = table.querySelector("canvas"), turning = table.querySelector(".turning"), message = table.querySelector("p");
  const doors = table.querySelector("input[type=range]"), download = table.querySelector("a");
  let stage = null; // renderer, scene, camera, controls, moving parts and walls of the scene that is open

  const three = () => globalThis.THREE ?? new Promise((resolve, reject) => {
    const script = document.createElement("script");
    script.src = table.dataset.viewer;
    script.addEventListener("load", () => resolve(globalThis.THREE));
    script.addEventListener("error", () => reject(new Error(`${script.src} is missing: keep it beside this page.`)));
    document.head.append(script);
  });

  const EDGE_ON = 0.1; // sine of the angle to a wall below which it shows nothing of itself

  // Doors and drawers stand open by a part (0 to 1) of their range; walls seen from behind or edge-on are hidden.
  const draw = () => {
    if (!stage || !table.open) return;
    const { THREE, renderer, scene, camera, joints, walls } = stage;
    const { clientWidth: width, clientHeight: height } = canvas;
    renderer.setSize(width, height, false);
    camera.aspect = width / height;
    const wider = Math.max(1, stage.shape / camera.aspect); // on a phone all of the picture's width is seen
    camera.fov = 2 * Math.atan(wider * Math.tan(stage.lens / 2)) * 180 / Math.PI;
    camera.updateProjectionMatrix();
    for (const { node, closed } of joints) {
      const { joint, axis, lower, upper } = node.userData, by = doors.value / 100 * (upper - lower);
      const along = new THREE.Vector3(...axis);
      const motion = joint === "prismatic" ? new THREE.Matrix4().setPosition(along.multiplyScalar(by))
        : new THREE.Matrix4().makeRotationAxis(along, by);
      node.matrix.multiplyMatrices(closed, motion);
    }
    for (const wall of walls) { // its x axis points into the room
      const inward = new THREE.Vector3().setFromMatrixColumn(wall.matrixWorld, 0);
      const eye = camera.position.clone().sub(new THREE.Vector3().setFromMatrixPosition(wall.matrixWorld));
      wall.visible = inward.dot(eye) > EDGE_ON * eye.length();
    }
    renderer.render(scene, camera);
  };
  const turn = (right, up, nearer = 1) => {
    const { THREE, camera, controls } = stage;
    const from = new THREE.Spherical().setFromVector3(camera.position.clone().sub(controls.target));
    from.set(nearer * from.radius, from.phi - up, from.theta + right).makeSafe();
    camera.position.setFromSpherical(from).add(controls.target);
    controls.update();
  };
  const spin = (on) => {
    if (!stage) return;
    stage.controls.autoRotate = on;
    turning.ariaPressed = String(on);
    turning.textContent = on ? "Stop turning" : "Turn";
    const step = () => {
      if (!stage.controls.autoRotate || !table.open) return;
      stage.controls.update(); // draws what has changed
      requestAnimationFrame(step);
    };
    if (on) requestAnimationFrame(step);
  };

  const staged = (THREE, gltf) => {
    stage?.controls.dispose();
    const renderer = stage?.renderer ?? new THREE.WebGLRenderer({ canvas, antialias: true, preserveDrawingBuffer: true });
    renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    renderer.shadowMap.enabled = true;
    const scene = new THREE.Scene(), camera = gltf.cameras[0], joints = [], walls = [];
    scene.background = new THREE.Color("#d1d1d6");
    scene.add(gltf.scene);
    scene.updateMatrixWorld(true);
    gltf.scene.traverse((node) => {
      const { joint, surface } = node.userData;
      if (node.isMesh) {
        node.material = new THREE.MeshLambertMaterial({ color: node.material.color, map: node.material.map, side: THREE.DoubleSide });
        node.castShadow = !surface;
        node.receiveShadow = true;
      }
      if (surface === "wall") walls.push(node);
      if (joint) {
        node.matrixAutoUpdate = false;
        joints.push({ node, closed: node.matrix.clone() });
      }
    });
    const { light, center, radius } = gltf.scene.userData, reach = 1.3 * radius, middle = new THREE.Vector3(...center);
    const sun = new THREE.DirectionalLight("white", 0.55 * Math.PI); // a white surface that faces it is white
    sun.target.position.copy(middle);
    sun.position.copy(middle).addScaledVector(new THREE.Vector3(...light), -2 * reach);
    sun.castShadow = true;
    sun.shadow.mapSize.set(2048, 2048);
    sun.shadow.normalBias = 0.02; // metres
    Object.assign(sun.shadow.camera, { left: -reach, right: reach, top: reach, bottom: -reach, near: 0, far: 4 * reach });
    scene.add(sun, sun.target, new THREE.AmbientLight("white", 0.5 * Math.PI));
    scene.attach(camera);
    const ahead = camera.getWorldDirection(new THREE.Vector3());
    const along = Math.max(1, ahead.dot(middle.clone().sub(camera.position))); // as deep as the camera looks
    const controls = new THREE.OrbitControls(camera, canvas);
    controls.target.copy(camera.position).addScaledVector(ahead, along);
    Object.assign(controls, { enablePan: false, minDistance: 0.6, maxDistance: 3 * Math.max(along, radius), maxPolarAngle: 0.49 * Math.PI });
    controls.addEventListener("change", draw);
    controls.addEventListener("start", () => spin(false));
    return { THREE, renderer, scene, camera, controls, joints, walls, shape: camera.aspect, lens: camera.fov * Math.PI / 180 };
  };

  const open = async (button) => {
    const held = document.getElementById(button.dataset.scene).textContent.trim();
    const packed = Uint8Array.from(atob(held), (letter) => letter.charCodeAt(0));
    const bytes = await new Response(new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"))).arrayBuffer();
    URL.revokeObjectURL(download.href);
    download.href = URL.createObjectURL(new Blob([bytes], { type: "model/gltf-binary" }));
    download.download = `${button.dataset.scene.replace("compare", "scene")}.glb`;
    table.showModal();
    try {
      const THREE = await three();
      stage = staged(THREE, await new THREE.GLTFLoader().parseAsync(bytes, ""));
      message.hidden = true;
    } catch (error) {
      message.hidden = false;
      message.textContent = `${error.message} The scene can be saved and opened elsewhere.`;
      return;
    }
    doors.value = 0;
    doors.closest("label").hidden = stage.joints.length === 0;
    stage.controls.update();
    draw();
    spin(!matchMedia("(prefers-reduced-motion: reduce)").matches);
    canvas.focus();
  };
  for (const button of document.querySelectorAll("button.turn")) button.addEventListener("click", () => open(button));

  turning.addEventListener("click", () => spin(!stage?.controls.autoRotate));
  doors.addEventListener("input", draw);
  table.querySelector(".close").addEventListener("click", () => table.close());
  const KEYS = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1], "+": [0, 0, 0.9], "-": [0, 0, 1.1] };
  canvas.addEventListener("keydown", (event) => {
    if (!(event.key in KEYS) || !stage) return;
    event.preventDefault();
    spin(false);
    turn(...KEYS[event.key]);
  });
  addEventListener("resize", draw);
}
