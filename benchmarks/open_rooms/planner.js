// Furniture of react-planner, which is code for three.js, as OBJ files in metres: node planner.js ARCHIVES OUT ITEM...
// ARCHIVES holds the unpacked npm packages react-planner, three and babel-standalone; of OUT each item gets a folder.
const fs = require('fs'), path = require('path'), Module = require('module');

const [archives, out, ...items] = process.argv.slice(2);
const babel = require(path.resolve(archives, 'babel-standalone/package/babel.js'));
const three = require(path.resolve(archives, 'three/package/build/three.js'));
const catalogue = path.resolve(archives, 'react-planner/package/demo/src/catalog/items');
const CM = {cm: 1, m: 100, ft: 30.48};
const provided = {three, path, react: {createElement() {}}, 'convert-units': x => ({from: a => ({to: b => x * CM[a] / CM[b]})})};

const load = Module._load;
Module._load = (name, ...rest) => provided[name] || load(name, ...rest);
for (const ending of ['.jsx', '.js'])
  Module._extensions[ending] = (module, file) => module._compile(
    babel.transform(fs.readFileSync(file, 'utf8'), {presets: ['react', ['env', {targets: {node: 20}}]]}).code, file);
for (const ending of ['.jpg', '.png', '.obj', '.mtl'])
  Module._extensions[ending] = (module, file) => { module.exports = file; };
global.window = {};
three.TextureLoader.prototype.load = file => Object.assign(new three.Texture(), {name: file});
three.FileLoader.prototype.load = (file, then) => then(fs.readFileSync(file, 'utf8'));

function asImmutable(value) {
  if (typeof value !== 'object') return value;
  const get = key => asImmutable(value[key]);
  return {get, getIn: keys => keys.reduce((found, key) => found[key], value), toJS: () => value};
}

function write(name, whole) {
  const folder = path.join(out, name), text = [`mtllib ${name}.mtl`], looks = new Map(), numbers = {v: new Map(), vt: new Map()};
  fs.mkdirSync(folder, {recursive: true});
  const number = (kind, values) => {
    const line = `${kind} ${values.map(x => (Math.round(x * 1e5) / 1e5 + 0).toString()).join(' ')}`;
    if (!numbers[kind].has(line)) { text.push(line); numbers[kind].set(line, numbers[kind].size + 1); }
    return numbers[kind].get(line);
  };
  whole.updateMatrixWorld(true);
  const visit = object => {
    if (object.isMesh && object.material.visible !== false) {
      let shape = object.geometry.isGeometry ? new three.BufferGeometry().fromGeometry(object.geometry) : object.geometry;
      if (shape.index) shape = shape.toNonIndexed();
      const {position, uv} = shape.attributes, point = new three.Vector3();
      const groups = shape.groups.length ? shape.groups : [{start: 0, count: position ? position.count : 0, materialIndex: 0}];
      for (const {start, count, materialIndex} of groups) {
        const material = [].concat(object.material)[Array.isArray(object.material) ? materialIndex : 0];
        if (!looks.has(material)) looks.set(material, `look_${looks.size}`);
        text.push(`usemtl ${looks.get(material)}`);
        for (let first = start; first < start + count; first += 3) text.push('f ' + [0, 1, 2].map(k => {
          point.fromBufferAttribute(position, first + k).applyMatrix4(object.matrixWorld).divideScalar(100);
          const corner = number('v', point.toArray());
          if (!material.map || !uv) return corner;
          const {x, y} = material.map.repeat;
          return `${corner}/${number('vt', [uv.getX(first + k) * x, uv.getY(first + k) * y])}`;
        }).join(' '));
      }
    }
    (object.isLOD ? object.levels.slice(0, 1).map(level => level.object) : object.children).forEach(visit);
  };
  visit(whole);
  const described = [...looks].map(([material, look]) => {
    const lines = [`newmtl ${look}`, `Kd ${material.color.toArray().join(' ')}`, `d ${material.transparent ? material.opacity : 1}`];
    if (material.map) {
      fs.copyFileSync(material.map.name, path.join(folder, path.basename(material.map.name)));
      lines.push(`map_Kd ${path.basename(material.map.name)}`);
    }
    return lines.join('\n');
  });
  fs.writeFileSync(path.join(folder, `${name}.obj`), text.join('\n') + '\n');
  fs.writeFileSync(path.join(folder, `${name}.mtl`), described.join('\n') + '\n');
}

for (const name of items) {
  let seed = 1;
  Math.random = () => (seed = seed * 16807 % 2147483647) / 2147483647;
  const item = require(path.join(catalogue, name, 'planner-element.jsx')).default;
  const told = Object.entries(item.properties).map(([key, {defaultValue}]) => [key, defaultValue]);
  const element = {properties: asImmutable(Object.fromEntries(told)), rotation: 0, selected: false};
  item.render3D(element, {}, {unit: 'cm'}).then(whole => write(name, whole));
}
