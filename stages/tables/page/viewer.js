// A generated scene to turn round: reads the binary glTF that `generation draw` wrote for it and draws it with WebGL 2.
// Nothing is made before somebody presses a button; without WebGL the button says so.
const SHADE = `#version 300 es
precision highp float;
precision highp sampler2DShadow;
in vec3 at, facing; in vec2 place;
uniform vec4 colour; uniform bool textured; uniform sampler2D image;
uniform vec3 light; uniform mat4 fromLight; uniform sampler2DShadow shadows;
out vec4 pixel;
void main() {
  vec3 n = normalize(gl_FrontFacing ? facing : -facing);
  vec3 base = colour.rgb * (textured ? pow(texture(image, place).rgb, vec3(2.2)) : vec3(1));
  vec3 seen = (fromLight * vec4(at + n * 0.015, 1)).xyz * 0.5 + 0.5;
  float lit = 0.0;
  for (int k = 0; k < 4; k++) lit += texture(shadows, seen + vec3(k % 2, k / 2, 0) * 0.0005 - vec3(0, 0, 0.0008)) / 4.0;
  float key = max(dot(n, -light), 0.0) * lit, fill = max(dot(n, normalize(vec3(light.x, 1.4, light.z))), 0.0);
  pixel = vec4(pow(base * (0.43 + 0.48 * key + 0.12 * fill), vec3(1.0 / 2.2)), 1);
}`;
const PLACE = `#version 300 es
layout(location = 0) in vec3 position; layout(location = 1) in vec3 normal; layout(location = 2) in vec2 uv;
uniform mat4 model, view; out vec3 at, facing; out vec2 place;
void main() {
  at = (model * vec4(position, 1)).xyz; facing = mat3(model) * normal; place = uv; gl_Position = view * vec4(at, 1);
}`;
const NOTHING = "#version 300 es\nprecision lowp float; void main() {}";

// 4x4 matrices, column by column as glTF and WebGL have them.
const UNIT = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];
const times = (a, b) => UNIT.map((_, i) => [0, 1, 2, 3].reduce((sum, k) => sum + a[i % 4 + 4 * k] * b[4 * (i >> 2) + k], 0));
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const minus = (a, b) => a.map((value, i) => value - b[i]);
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (a) => a.map((value) => value / Math.hypot(...a));
const moved = (m, p) => [0, 1, 2].map((i) => m[i] * p[0] + m[i + 4] * p[1] + m[i + 8] * p[2] + m[i + 12]);
const looking = (eye, target, up) => {
  const z = unit(minus(eye, target)), x = unit(cross(up, z)), y = cross(z, x);
  return [x[0], y[0], z[0], 0, x[1], y[1], z[1], 0, x[2], y[2], z[2], 0, -dot(x, eye), -dot(y, eye), -dot(z, eye), 1];
};
const perspective = (angle, aspect, near, far) => {
  const f = 1 / Math.tan(angle / 2);
  return [f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (far + near) / (near - far), -1, 0, 0, 2 * far * near / (near - far), 0];
};
const orthographic = (r) => [1 / r, 0, 0, 0, 0, 1 / r, 0, 0, 0, 0, -1 / r, 0, 0, 0, -1, 1]; // eye at distance r
const turned = ([x, y, z], angle) => {
  const c = Math.cos(angle), s = Math.sin(angle), t = 1 - c;
  return [t * x * x + c, t * x * y + s * z, t * x * z - s * y, 0, t * x * y - s * z, t * y * y + c, t * y * z + s * x, 0,
          t * x * z + s * y, t * y * z - s * x, t * z * z + c, 0, 0, 0, 0, 1];
};

// The pieces of a binary glTF: every mesh with its node, every node with its parent.
const readScene = async (bytes) => {
  const view = new DataView(bytes), length = view.getUint32(12, true);
  const tree = JSON.parse(new TextDecoder().decode(new Uint8Array(bytes, 20, length)));
  const start = 28 + length;
  const array = (index) => {
    const { bufferView, byteOffset = 0, componentType, count, type } = tree.accessors[index];
    const Kind = { 5126: Float32Array, 5125: Uint32Array, 5123: Uint16Array, 5121: Uint8Array }[componentType];
    return new Kind(bytes, start + (tree.bufferViews[bufferView].byteOffset ?? 0) + byteOffset,
                    count * { SCALAR: 1, VEC2: 2, VEC3: 3, VEC4: 4 }[type]);
  };
  const pictures = await Promise.all((tree.images ?? []).map(({ bufferView, mimeType }) => {
    const { byteOffset = 0, byteLength } = tree.bufferViews[bufferView];
    return createImageBitmap(new Blob([new Uint8Array(bytes, start + byteOffset, byteLength)], { type: mimeType }));
  }));
  const nodes = tree.nodes.map((node) => ({ matrix: UNIT, extras: {}, ...node, parent: null }));
  nodes.forEach((node, index) => (node.children ?? []).forEach((child) => { nodes[child].parent = index; }));
  const texture = (index) => {
    const { source, extensions } = tree.textures[index];
    return pictures[extensions?.EXT_texture_webp?.source ?? source];
  };
  const parts = nodes.flatMap((node, index) => node.mesh === undefined ? [] : tree.meshes[node.mesh].primitives.map((part) => {
    const { baseColorFactor = [1, 1, 1, 1], baseColorTexture } = tree.materials[part.material].pbrMetallicRoughness;
    return { node: index, indices: array(part.indices), colour: baseColorFactor,
             attributes: ["POSITION", "NORMAL", "TEXCOORD_0"].map((name) => name in part.attributes ? array(part.attributes[name]) : null),
             image: baseColorTexture ? texture(baseColorTexture.index) : null };
  }));
  const eye = nodes.find((node) => node.camera !== undefined);
  const { yfov, aspectRatio } = tree.cameras[eye.camera].perspective;
  return { nodes, parts, eye: eye.matrix, lens: yfov, shape: aspectRatio, ...tree.scenes[0].extras };
};

// Where each node stands when doors and drawers are open by a part (0 to 1) of their range.
const places = (nodes, open) => {
  const found = [];
  const of = (index) => found[index] ??= (() => {
    const { matrix, parent, extras: { joint, axis, lower, upper } } = nodes[index];
    const by = open * (upper - lower);
    const motion = joint === "revolute" ? turned(axis, by)
      : joint === "prismatic" ? [...UNIT.slice(0, 12), ...axis.map((value) => value * by), 1] : UNIT;
    const here = joint ? times(matrix, motion) : matrix;
    return parent === null ? here : times(of(parent), here);
  })();
  return nodes.map((_, index) => of(index));
};

const program = (gl, fragment) => {
  const made = gl.createProgram();
  for (const [kind, text] of [[gl.VERTEX_SHADER, PLACE], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    gl.attachShader(made, shader);
  }
  gl.linkProgram(made);
  const at = new Map();
  return { made, at: (name) => at.get(name) ?? at.set(name, gl.getUniformLocation(made, name)).get(name) };
};

// A renderer of one scene on one WebGL context: draw(eye, target, aspect, open).
const rendererOf = (gl, scene) => {
  const seen = program(gl, SHADE), cast = program(gl, NOTHING), MAP = 2048;
  const depth = gl.createTexture(), frame = gl.createFramebuffer();
  gl.bindTexture(gl.TEXTURE_2D, depth);
  gl.texStorage2D(gl.TEXTURE_2D, 1, gl.DEPTH_COMPONENT24, MAP, MAP);
  for (const [key, value] of [[gl.TEXTURE_COMPARE_MODE, gl.COMPARE_REF_TO_TEXTURE], [gl.TEXTURE_MAG_FILTER, gl.LINEAR],
    [gl.TEXTURE_MIN_FILTER, gl.LINEAR], [gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE], [gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE]]) {
    gl.texParameteri(gl.TEXTURE_2D, key, value);
  }
  gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
  gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.TEXTURE_2D, depth, 0);
  const blank = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, blank);
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, 1, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
  const textures = new Map();
  for (const part of scene.parts) {
    part.shape = gl.createVertexArray();
    gl.bindVertexArray(part.shape);
    part.attributes.forEach((values, location) => {
      if (!values) return;
      gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
      gl.bufferData(gl.ARRAY_BUFFER, values, gl.STATIC_DRAW);
      gl.enableVertexAttribArray(location);
      gl.vertexAttribPointer(location, location < 2 ? 3 : 2, gl.FLOAT, false, 0, 0);
    });
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, Uint32Array.from(part.indices), gl.STATIC_DRAW);
    part.texture = blank;
    if (part.image) {
      if (!textures.has(part.image)) {
        textures.set(part.image, gl.createTexture());
        gl.bindTexture(gl.TEXTURE_2D, textures.get(part.image));
        gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, gl.RGBA, gl.UNSIGNED_BYTE, part.image);
        gl.generateMipmap(gl.TEXTURE_2D);
      }
      part.texture = textures.get(part.image);
    }
  }
  gl.enable(gl.DEPTH_TEST);
  const { center, radius } = scene, reach = 1.3 * radius;
  const from = center.map((value, i) => value - reach * scene.light[i]);
  const fromLight = times(orthographic(reach), looking(from, center, Math.abs(scene.light[1]) > 0.99 ? [1, 0, 0] : [0, 1, 0]));
  const each = (use, view, standing, hidden) => {
    gl.useProgram(use.made);
    gl.uniformMatrix4fv(use.at("view"), false, view);
    for (const part of scene.parts) {
      if (hidden(part.node)) continue;
      gl.uniformMatrix4fv(use.at("model"), false, standing[part.node]);
      if (use === seen) {
        gl.uniform4fv(use.at("colour"), part.colour);
        gl.uniform1i(use.at("textured"), part.image ? 1 : 0);
        gl.bindTexture(gl.TEXTURE_2D, part.texture);
      }
      gl.bindVertexArray(part.shape);
      gl.drawElements(gl.TRIANGLES, part.indices.length, gl.UNSIGNED_INT, 0);
    }
  };
  return (eye, target, open) => {
    const { drawingBufferWidth: width, drawingBufferHeight: height } = gl, standing = places(scene.nodes, open);
    const surface = (index) => scene.nodes[index].extras.surface; // floor, or a wall, whose x axis points into the room
    const behind = (index) => surface(index) === "wall"
      && dot(standing[index].slice(0, 3), minus(eye, standing[index].slice(12, 15))) < 0;
    gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
    gl.viewport(0, 0, MAP, MAP);
    gl.clear(gl.DEPTH_BUFFER_BIT);
    each(cast, fromLight, standing, surface);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.viewport(0, 0, width, height);
    gl.clearColor(0.82, 0.82, 0.84, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.useProgram(seen.made);
    gl.uniform3fv(seen.at("light"), scene.light);
    gl.uniformMatrix4fv(seen.at("fromLight"), false, fromLight);
    gl.uniform1i(seen.at("image"), 0);
    gl.uniform1i(seen.at("shadows"), 1);
    gl.activeTexture(gl.TEXTURE1);
    gl.bindTexture(gl.TEXTURE_2D, depth);
    gl.activeTexture(gl.TEXTURE0);
    const wider = Math.max(1, scene.shape * height / width); // on a phone all of the picture's width is seen
    const lens = 2 * Math.atan(wider * Math.tan(scene.lens / 2));
    const view = times(perspective(lens, width / height, 0.05, 80), looking(eye, target, [0, 1, 0]));
    each(seen, view, standing, behind);
  };
};
