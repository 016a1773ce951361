// What the address of the page says.
//
//   ?job=ID or ?tileset=PATH   what to show; a path on this server
//   ?err=PIXELS                error on screen to refine to
//   ?bg=COLOUR                 flat background, no lights' effects on it: for measuring pictures
//   ?noui                      no panel
//   ?cam=x,y,z&at=x,y,z        camera in metres of the scene, z up; the same after # wins, and is
//                              kept up to date there, so that a link shows the same view
import { Vector3 } from 'three';

function vector(text) {
  const numbers = (text ?? '').split(',').map(Number);
  return numbers.length === 3 && numbers.every(Number.isFinite) ? new Vector3(...numbers) : null;
}

export function readParameters(location) {
  const query = new URLSearchParams(location.search);
  const hash = new URLSearchParams(location.hash.slice(1));
  const either = (key) => hash.get(key) ?? query.get(key);
  return {
    job: query.get('job'),
    tileset: query.get('tileset'),
    error: Number(query.get('err')) || null,
    background: query.get('bg'),
    noUi: query.has('noui'),
    camera: vector(either('cam')),
    target: vector(either('at')),
    navigation: either('nav'),
    colours: either('colours'),
  };
}

// Writes view and choices behind the # without a step in the history.
export function writeHash({ camera, target, navigation, colours }) {
  const short = (v) => v.toArray().map((x) => Number(x.toFixed(2))).join(',');
  const parts = [`cam=${short(camera)}`, `at=${short(target)}`];
  if (navigation !== 'orbit') parts.push(`nav=${navigation}`);
  if (colours !== 'natural') parts.push(`colours=${colours}`);
  history.replaceState(null, '', `#${parts.join('&')}`);
}
