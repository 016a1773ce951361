// The viewer: puts the parts together and runs the frames.
import { Box3, Sphere, Vector3 } from 'three';

import { Job, listJobs } from './job.js';
import { Navigation } from './navigation.js';
import { Panel } from './panel.js';
import { readParameters, writeHash } from './parameters.js';
import { Stage } from './stage.js';
import { Terrain } from './terrain.js';

const parameters = readParameters(location);
const stage = new Stage(document.getElementById('view'), parameters.background);
const terrain = new Terrain(stage);
const navigation = new Navigation(stage, terrain);
const world = new Sphere(new Vector3(), 1000);
let colours = 'natural';

const panel = new Panel({
  navigation: (mode) => { navigation.mode = mode; },
  colours: (mode) => { colours = mode; terrain.setLook({ colours }); },
  wireframe: (on) => terrain.setLook({ wireframe: on }),
  skirts: (on) => terrain.setLook({ skirts: on }),
  bounds: (on) => { terrain.showBounds = on; },
  shadows: (on) => { stage.shadows = on; },
  fog: (on) => { stage.fog = on; },
  error: (pixels) => terrain.setErrorTarget(pixels),
  home: () => showWhole(),
});

function showWhole() {
  if (terrain.box) navigation.lookAtWhole(terrain.box, stage.camera.aspect);
}

// The camera is set as soon as the world's size is known, so that only needed tiles are fetched, and
// again when the world of a running job grows, unless someone has chosen a view.
const seen = new Box3();
function place() {
  const box = terrain.box;
  if (!box || box.equals(seen)) return;
  const first = seen.isEmpty();
  seen.copy(box);
  box.getBoundingSphere(world);
  const { camera, target } = parameters;
  if (first && camera) navigation.lookFrom(camera, target ?? world.center);
  else if (!camera && !navigation.touched) showWhole();
  if (first && parameters.navigation) panel.choose('navigation', parameters.navigation);
}

let saveSoon = 0;
function save() {
  clearTimeout(saveSoon);
  saveSoon = setTimeout(() => writeHash({
    camera: stage.camera.position, target: navigation.target, navigation: navigation.mode, colours,
  }), 300);
}

// Frames are drawn when something has changed. `idle` counts those since nothing did.
const state = { idle: 0, errors: [], terrain, stage, navigation };
let last = performance.now();
let drawn = 0;
function frame(now) {
  stage.resize();
  place();
  const moved = navigation.update((now - last) / 1000);
  last = now;
  stage.camera.updateMatrixWorld();
  if (moved) {
    stage.needsRender = true;
    save();
  }
  terrain.update();
  if (!seen.isEmpty()) stage.fit(navigation.target, navigation.scale, world);
  state.idle = moved || stage.needsRender || terrain.busy ? 0 : state.idle + 1;
  if (stage.needsRender) {
    stage.render();
    ++drawn;
  }
  requestAnimationFrame(frame);
}

setInterval(() => {
  panel.showStatistics(terrain.statistics(), drawn === 0 ? 'idle' : `${drawn * 2}/s`);
  drawn = 0;
}, 500);

function open() {
  terrain.addEventListener('error', ({ message }) => {
    state.errors.push(message);
    panel.error_message = message;
  });
  if (parameters.error) panel.error = parameters.error;
  if (parameters.colours) panel.choose('colours', parameters.colours);
  if (parameters.noUi) document.getElementById('panel').hidden = true;
  stage.shadows = !parameters.background;
  if (parameters.job) followJob(parameters.job);
  else if (parameters.tileset) terrain.open(new URL(parameters.tileset, location).href);
  else listJobs().then((jobs) => panel.showJobs(jobs));
}

function followJob(id) {
  const job = new Job(id);
  job.addEventListener('status', ({ info }) => panel.showJob(info));
  job.addEventListener('missing', () => { panel.error_message = `There is no job ${id}.`; });
  job.addEventListener('tileset', () => terrain.open(new URL(job.tileset, location).href));
  job.follow();
}

globalThis.hoodoo = state; // for tests, and for the curious
open();
requestAnimationFrame(frame);
