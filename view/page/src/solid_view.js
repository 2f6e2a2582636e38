// Fibre and ferrule in 3-D at true scale, the ferrule cut open along its axis.
import {
  AmbientLight, BackSide, BufferGeometry, Color, ConeGeometry, CylinderGeometry, DirectionalLight, DoubleSide,
  Float32BufferAttribute, Group, LatheGeometry, LineBasicMaterial, LineSegments, Mesh, MeshBasicMaterial,
  MeshLambertMaterial, PerspectiveCamera, Quaternion, Scene as Stage, SphereGeometry, Vector2, Vector3,
  WebGLRenderer,
} from 'three';
import {length, round125} from './format.js';
import {software} from './software.js';
import {contacts, drawnLength, fibreAt, filledWithLiquid, termForces} from './shape.js';

/** @typedef {import('./table.js').Read} Read @typedef {import('./recording.js').Scene} Scene
 * @typedef {import('./theme.js').Colours} Colours */

const kRings = 40, kSides = 48;
const kUp = new Vector3(0, 1, 0);

export class SolidView {
  /** @param {HTMLCanvasElement} canvas @param {HTMLElement} note where scale and factors are said */
  constructor(canvas, note) {
    this.canvas = canvas;
    this.note = note;
    this.renderer = new WebGLRenderer({canvas, antialias: !software, alpha: true, powerPreference: 'low-power'});
    this.camera = new PerspectiveCamera(28, 1, 5, 60000);
    /** @type {Stage | null} */
    this.stage = null;
    this.angle = {turn: 0.62, rise: 0.36, zoom: 1};
    this.target = new Vector3();
    this.distance = 1000;
    this.orbit();
  }

  // Drag turns, the wheel comes nearer.
  orbit() {
    /** @type {{x: number, y: number} | null} */
    let from = null;
    this.canvas.addEventListener('pointerdown', (event) => {
      from = {x: event.clientX, y: event.clientY};
      this.canvas.setPointerCapture(event.pointerId);
    });
    this.canvas.addEventListener('pointermove', (event) => {
      if (!from) return;
      this.turn(-0.008 * (event.clientX - from.x), 0.008 * (event.clientY - from.y));
      from = {x: event.clientX, y: event.clientY};
    });
    const end = () => { from = null; };
    this.canvas.addEventListener('pointerup', end);
    this.canvas.addEventListener('pointercancel', end);
    this.canvas.addEventListener('wheel', (event) => {
      event.preventDefault();
      this.zoom(Math.exp(0.001 * event.deltaY));
    }, {passive: false});
    this.canvas.addEventListener('keydown', (event) => {
      const step = {ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1]}[event.key];
      if (step) this.turn(step[0], step[1]);
      else if (event.key === '+' || event.key === '=') this.zoom(0.85);
      else if (event.key === '-') this.zoom(1.18);
      else return;
      event.preventDefault();
      event.stopPropagation();
    });
  }

  /** @param {number} turn @param {number} rise [rad] */
  turn(turn, rise) {
    this.angle.turn += turn;
    this.angle.rise = Math.max(-1.4, Math.min(1.4, this.angle.rise + rise));
  }

  /** @param {number} factor of the distance */
  zoom(factor) {
    this.angle.zoom = Math.max(0.12, Math.min(8, this.angle.zoom * factor));
  }

  /** Everything that the scene and the theme decide. @param {Scene} scene @param {Colours} colours */
  build(scene, colours) {
    const g = scene.geometry;
    this.scene = scene;
    this.colours = colours;
    const stage = new Stage();
    stage.add(new AmbientLight(0xffffff, 1.7));
    for (const [x, y, z, power] of [[0.6, 1, 0.9, 1.9], [-0.7, 0.2, 0.6, 0.6]]) {
      const light = new DirectionalLight(0xffffff, power);
      light.position.set(x, y, z);
      stage.add(light);
    }
    const outer = 1.25 * g.mouth_radius_um + 90;
    const inner = -Math.min(g.bore_length_um, Math.max(2.2 * scene.success_depth_um, 220));
    this.ferrule(stage, g, inner, outer, colours);
    if (filledWithLiquid(scene)) this.liquid(stage, g.bore_radius_um, inner, colours);

    this.fibreGeometry = new BufferGeometry();
    this.fibreGeometry.setAttribute('position', new Float32BufferAttribute(new Float32Array(3 * (kRings + 1) * kSides), 3));
    this.fibreGeometry.setAttribute('normal', new Float32BufferAttribute(new Float32Array(3 * (kRings + 1) * kSides), 3));
    this.fibreGeometry.setIndex(tubeIndex());
    this.fibre = new Mesh(this.fibreGeometry, new MeshLambertMaterial({color: new Color(colours.fibre), transparent: true, opacity: 0.88, side: DoubleSide}));
    this.fibre.frustumCulled = false;
    stage.add(this.fibre);
    this.end = new Mesh(new CylinderGeometry(g.fibre_radius_um, g.fibre_radius_um, 0.6, kSides),
        new MeshLambertMaterial({color: new Color(colours.fibreEdge)}));
    this.core = new Mesh(new CylinderGeometry(4.5, 4.5, 1.6, 24), new MeshBasicMaterial({color: new Color(colours.contact)}));
    stage.add(this.end, this.core);
    this.otherGeometry = this.fibreGeometry.clone();
    this.other = new Mesh(this.otherGeometry, new MeshLambertMaterial({color: new Color(colours.ghost), transparent: true, opacity: 0.35, side: DoubleSide, depthWrite: false}));
    this.other.frustumCulled = false;
    stage.add(this.other);

    const dot = new SphereGeometry(0.09 * g.fibre_radius_um, 20, 14);
    this.dots = [0, 1].map(() => {
      const mesh = new Mesh(dot, new MeshBasicMaterial({color: new Color(colours.contact), depthTest: false, transparent: true}));
      mesh.renderOrder = 3;
      stage.add(mesh);
      return mesh;
    });
    this.bridge = new Mesh(new SphereGeometry(0.16 * g.fibre_radius_um, 20, 14),
        new MeshLambertMaterial({color: new Color(colours.liquid), transparent: true, opacity: 0.75}));
    stage.add(this.bridge);
    this.arrows = new Map([...scene.terms, 'hand'].map((term) => {
      const arrow = makeArrow(new Color(term === 'hand' ? colours.hand : colours.terms[term] ?? colours.ink));
      stage.add(arrow);
      return [term, arrow];
    }));
    this.gripper = new Mesh(new CylinderGeometry(2.1 * g.fibre_radius_um, 2.1 * g.fibre_radius_um, 420, 6, 1),
        new MeshLambertMaterial({color: new Color(colours.hand), transparent: true, opacity: 0.8, flatShading: true}));
    stage.add(this.gripper);

    const bar = round125(2.2 * g.fibre_radius_um);
    this.bar = new LineSegments(new BufferGeometry().setFromPoints([
      new Vector3(0, 0, 0), new Vector3(bar, 0, 0), new Vector3(0, -8, 0), new Vector3(0, 8, 0), new Vector3(bar, -8, 0), new Vector3(bar, 8, 0),
    ]), new LineBasicMaterial({color: new Color(colours.ink), depthTest: false, transparent: true}));
    this.bar.position.set(g.lead_in_length_um + 60, -outer * 0.66, 0);
    this.bar.renderOrder = 4;
    this.barText = length(bar);
    stage.add(this.bar);

    const span = Math.max(g.lead_in_length_um, scene.start.distance_um) + Math.min(-inner, 260);
    this.target.set(0.18 * span, 0, 0);
    this.distance = 2.1 * Math.max(span, 1.7 * outer);
    this.stage?.traverse((thing) => { if (thing instanceof Mesh) thing.geometry.dispose(); });
    this.stage = stage;
  }

  /** @param {Stage} stage @param {Scene['geometry']} g @param {number} inner @param {number} outer @param {Colours} colours */
  ferrule(stage, g, inner, outer, colours) {
    // Profile (distance from the axis, x), turned about y by the lathe and laid along x.
    const profile = [new Vector2(g.bore_radius_um, inner), new Vector2(g.bore_radius_um, 0)];
    if (g.lead_in_length_um > 0) profile.push(new Vector2(g.mouth_radius_um, g.lead_in_length_um));
    profile.push(new Vector2(outer, g.lead_in_length_um), new Vector2(outer, inner));
    const group = new Group();
    const solid = new MeshLambertMaterial({color: new Color(colours.ferrule), side: DoubleSide, flatShading: false});
    for (let i = 0; i + 1 < profile.length; ++i)  // each piece by itself: sharp edges
      group.add(new Mesh(new LatheGeometry([profile[i], profile[i + 1]], 96, Math.PI / 2, Math.PI), solid));
    group.rotation.z = -Math.PI / 2;
    stage.add(group);
    // The two faces of the cut, in the plane z = 0.
    const cut = new MeshLambertMaterial({color: new Color(colours.ferruleCut), side: DoubleSide});
    const edges = [];
    for (const sign of [1, -1]) {
      const points = profile.map((p) => new Vector3(p.y, sign * p.x, 0));
      const geometry = new BufferGeometry().setFromPoints(points);
      // Convex pieces: the bore's part, then the lead-in's.
      const last = points.length - 1;
      geometry.setIndex(g.lead_in_length_um > 0 ? [0, 1, last, 1, 3, last, 1, 2, 3] : [0, 1, 2, 0, 2, 3]);
      geometry.computeVertexNormals();
      stage.add(new Mesh(geometry, cut));
      for (const p of points) p.z = 0.4;  // in front of the cut
      for (let i = 0; i + 1 < points.length; ++i) edges.push(points[i], points[i + 1]);
    }
    stage.add(new LineSegments(new BufferGeometry().setFromPoints(edges), new LineBasicMaterial({color: new Color(colours.ink)})));
  }

  /** @param {Stage} stage @param {number} radius @param {number} inner @param {Colours} colours */
  liquid(stage, radius, inner, colours) {
    const filled = new Mesh(new CylinderGeometry(radius, radius, -inner, kSides, 1, true, Math.PI / 2, Math.PI),
        new MeshLambertMaterial({color: new Color(colours.liquid), transparent: true, opacity: 0.55, side: BackSide}));
    filled.rotation.z = -Math.PI / 2;
    filled.position.x = inner / 2;
    stage.add(filled);
  }

  /** @param {Read} read @param {Read | null} other @param {number} bend */
  draw(read, other, bend) {
    const {stage, scene, canvas} = this;
    if (!stage || !scene || !this.fibreGeometry || !this.otherGeometry) return;
    const width = canvas.clientWidth, height = canvas.clientHeight;
    if (width < 8 || height < 8) return;
    // What software renders is no larger than it can at 4K.
    const ratio = Math.min(devicePixelRatio || 1, (software ? 700 : 2800) / Math.max(width, height));
    const size = this.renderer.getSize(new Vector2());
    if (size.x !== width || size.y !== height || this.renderer.getPixelRatio() !== ratio) {
      this.renderer.setPixelRatio(ratio);
      this.renderer.setSize(width, height, false);
      this.camera.aspect = width / height;
    }
    this.place(width / height);
    tube(this.fibreGeometry, scene, read, bend);
    if (this.other) this.other.visible = other !== null;
    if (other) tube(this.otherGeometry, scene, other, bend);
    this.placeParts(scene, read, bend);
    this.renderer.render(stage, this.camera);
    const force = this.forceScale(read);
    const text = `true scale; bar ${this.barText}; arrows ${length(1).split(' ')[0]} \u00b5N = ${force < 10 ? force.toFixed(1) : Math.round(force)} \u00b5m` +
        (scene.geometry.free_length_um > 0 && bend !== 1 ? `; bending \u00d7${bend}` : '');
    if (this.note.textContent !== text) this.note.textContent = text;
  }

  /** @param {number} aspect */
  place(aspect) {
    const {turn, rise, zoom} = this.angle;
    const far = this.distance * zoom * Math.max(1, 1.45 / aspect);
    this.camera.position.set(
        this.target.x + far * Math.sin(turn) * Math.cos(rise), this.target.y + far * Math.sin(rise),
        this.target.z + far * Math.cos(turn) * Math.cos(rise));
    this.camera.near = far / 50;
    this.camera.far = far * 30;
    this.camera.lookAt(this.target);
    this.camera.updateProjectionMatrix();
  }

  /** Length of an arrow [um/uN]: the limit is three fibre radii long. @param {Read} read */
  forceScale(read) {
    const limit = read('limit_uN');
    return limit > 0 && this.scene ? 3 * this.scene.geometry.fibre_radius_um / limit : 0;
  }

  /** @param {Scene} scene @param {Read} read @param {number} bend */
  placeParts(scene, read, bend) {
    if (!this.end || !this.core || !this.dots || !this.bridge || !this.arrows || !this.gripper) return;
    const tip = new Vector3(read('tip_x_um'), read('tip_y_um'), read('tip_z_um'));
    const along = new Vector3(1, read('tip_ay_rad'), read('tip_az_rad')).normalize();
    const turn = new Quaternion().setFromUnitVectors(kUp, along);
    for (const part of [this.end, this.core]) {
      part.position.copy(tip);
      part.quaternion.copy(turn);
    }
    const found = contacts(read);
    for (const dot of this.dots) dot.visible = false;
    for (const {place, at} of found) {
      this.dots[place].visible = true;
      this.dots[place].position.set(at[0], at[1], at[2]);
    }
    this.bridge.visible = read('bridge_on') > 0.5;
    const away = new Vector2(tip.y, tip.z), r = scene.geometry.fibre_radius_um;
    if (away.length() > 0) this.bridge.position.set(Math.max(tip.x, 0), tip.y + r * tip.y / away.length(), tip.z + r * tip.z / away.length());
    const scale = this.forceScale(read);
    for (const {term, force, at} of termForces(scene, read)) {
      const arrow = this.arrows.get(term);
      if (arrow) pointArrow(arrow, new Vector3(...at), new Vector3(...force).multiplyScalar(scale));
    }
    const hand = this.arrows.get('hand');
    if (hand) pointArrow(hand, tip, new Vector3(read('force_x_uN'), read('force_y_uN'), read('force_z_uN')).multiplyScalar(scale));
    const s = scene.geometry.free_length_um || 900;
    this.gripper.position.set(...fibreAt(scene, read, s + 210, bend));
    this.gripper.quaternion.setFromUnitVectors(kUp, new Vector3(1, read('holder_ay_rad'), read('holder_az_rad')).normalize());
  }
}

/** @param {Color} colour */
function makeArrow(colour) {
  const material = new MeshBasicMaterial({color: colour, depthTest: false, transparent: true});
  const group = new Group();
  const shaft = new Mesh(new CylinderGeometry(2.2, 2.2, 1, 10), material);
  const head = new Mesh(new ConeGeometry(6.5, 16, 14), material);
  shaft.name = 'shaft';
  head.name = 'head';
  group.add(shaft, head);
  group.renderOrder = shaft.renderOrder = head.renderOrder = 5;
  return group;
}

/** @param {Group} arrow @param {Vector3} at @param {Vector3} vector [um] */
function pointArrow(arrow, at, vector) {
  const size = vector.length();
  arrow.visible = size > 3;
  if (!arrow.visible) return;
  const [shaft, head] = arrow.children, tipLength = Math.min(16, 0.6 * size);
  arrow.position.copy(at);
  arrow.quaternion.setFromUnitVectors(kUp, vector.normalize());
  shaft.scale.set(1, Math.max(0.1, size - tipLength), 1);
  shaft.position.set(0, (size - tipLength) / 2, 0);
  head.scale.setScalar(tipLength / 16);
  head.position.set(0, size - tipLength / 2, 0);
}

/** @returns {number[]} */
function tubeIndex() {
  const index = [];
  for (let ring = 0; ring < kRings; ++ring)
    for (let side = 0; side < kSides; ++side) {
      const a = ring * kSides + side, b = ring * kSides + (side + 1) % kSides;
      index.push(a, b, a + kSides, b, b + kSides, a + kSides);
    }
  return index;
}

/** The fibre's surface: dense rings near its end, where it is looked at. @param {BufferGeometry} geometry @param {Scene} scene @param {Read} read @param {number} bend */
function tube(geometry, scene, read, bend) {
  const position = geometry.getAttribute('position'), normal = geometry.getAttribute('normal');
  const radius = scene.geometry.fibre_radius_um, most = drawnLength(scene);
  for (let ring = 0, at = 0; ring <= kRings; ++ring) {
    const centre = fibreAt(scene, read, most * (ring / kRings) ** 2, bend);
    for (let side = 0; side < kSides; ++side, ++at) {
      const angle = 2 * Math.PI * side / kSides, c = Math.cos(angle), s = Math.sin(angle);
      position.setXYZ(at, centre[0], centre[1] + radius * c, centre[2] + radius * s);
      normal.setXYZ(at, 0, c, s);
    }
  }
  position.needsUpdate = normal.needsUpdate = true;
}
