// Where in the text of a scene something is wrong.
import { ensureSyntaxTree } from './vendor/codemirror.js';

const PARSE_MS = 1000;
const treeOf = (state) => ensureSyntaxTree(state, state.doc.length, PARSE_MS);

// The first place where the text is no JSON: {from, to, message}, or null.
function syntaxError(state) {
  try {
    JSON.parse(state.doc.toString());
    return null;
  } catch (error) {
    const at = errorPlace(state) ?? Number(/position (\d+)/.exec(error.message)?.[1] ?? 0);
    const from = Math.min(at, state.doc.length);
    const what = error.message.replace(/,? ?(at|in JSON at) position \d+.*| is not valid JSON|, "[^]*$/g, '');
    return { from, to: Math.min(from + 1, state.doc.length), message: state.doc.length === 0 ? 'The scene is empty.' : `${what}.` };
  }
}
function errorPlace(state) {
  let first = null;
  treeOf(state)?.iterate({ enter(node) {
    if (first === null && node.type.isError) first = node.from;
    return first === null;
  } });
  return first;
}

// Keys that an object has twice, which the service refuses, as marks. The text must be JSON.
function repeatedKeys(state) {
  const marks = [];
  treeOf(state)?.iterate({ enter({ name, node }) {
    if (name !== 'Object') return;
    const seen = new Set();
    for (const { name: key, key: { from, to } } of values(node, state)) {
      if (seen.has(key)) marks.push({ from, to, message: `The key ${JSON.stringify(key)} stands here twice.` });
      seen.add(key);
    }
  } });
  return marks.sort((a, b) => a.from - b.from);
}
// All for which the text cannot be sent.
export function unreadable(state) {
  const error = syntaxError(state);
  return error ? [error] : repeatedKeys(state);
}

// The members of an object or the elements of an array, as nodes.
function* values(node, state) {
  let index = 0;
  for (let child = node.firstChild; child; child = child.nextSibling) {
    if (node.name === 'Object' && child.name === 'Property') {
      const name = child.getChild('PropertyName');
      yield { name: JSON.parse(state.sliceDoc(name.from, name.to)), key: name, node: child.lastChild };
    } else if (node.name === 'Array' && !'[]⚠'.includes(child.name) && child.name !== ',') {
      yield { name: String(index++), key: child, node: child };
    }
  }
}

// The place of a JSON Pointer (RFC 6901): {from, to, whole}. Where the text has no such value, that of the innermost
// around it that it has; `whole` is false then.
export function placeOf(pointer, state) {
  let node = treeOf(state)?.topNode.firstChild;
  if (!node) return { from: 0, to: 0, whole: false };
  let key = null;
  for (const token of pointer.split('/').slice(1)) {
    const name = token.replaceAll('~1', '/').replaceAll('~0', '~');
    let found = null;
    for (const value of values(node, state)) if (value.name === name) found = value;
    if (!found) return { ...headOf(key ?? node, state), whole: false };
    ({ node, key } = found);
  }
  return { from: node.from, to: node.to, whole: true };
}
// Of a value its first line at most: a mark over all of an object tells nothing.
function headOf(node, state) {
  return { from: node.from, to: Math.min(node.to, state.doc.lineAt(node.from).to) };
}

// Findings of the service, [{pointer, detail}], as marks: [{from, to, message, pointer}] by place.
export function marksOf(findings, state) {
  return findings.map(({ pointer, detail }) => {
    const place = placeOf(pointer, state);
    const to = Math.max(Math.min(place.to, state.doc.lineAt(place.from).to), Math.min(place.from + 1, state.doc.length));
    return { from: place.from, to, message: detail, pointer };
  }).sort((a, b) => a.from - b.from);
}
