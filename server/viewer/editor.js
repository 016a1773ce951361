// The text of a scene: CodeMirror in a shadow root, where its styles are style sheets made by script. In the page itself they
// would be <style> elements, which the Content-Security-Policy refuses.
import {
  bracketMatching, codeFolding, defaultKeymap, drawSelection, EditorState, EditorView, foldGutter, foldKeymap,
  highlightActiveLine, highlightActiveLineGutter, HighlightStyle, history, historyKeymap, indentOnInput, json, keymap,
  lineNumbers, lintGutter, lintKeymap, setDiagnostics, syntaxHighlighting, tags,
} from './vendor/codemirror.js';
import { placeOf } from './findings.js';

const INK = '#eef2f5', SOFT = '#a9b6c0', ACCENT = '#f0a35e', PANEL = '#1a2229';

const theme = EditorView.theme({
  '&': { height: '100%', color: INK, backgroundColor: PANEL, fontSize: '13px' },
  '&.cm-focused': { outline: 'none' },  // the host has one
  '.cm-scroller': { fontFamily: 'ui-monospace, "DejaVu Sans Mono", Menlo, Consolas, monospace', lineHeight: '1.5' },
  '.cm-content': { caretColor: ACCENT },
  '.cm-cursor': { borderLeftColor: ACCENT },
  '.cm-gutters': { backgroundColor: PANEL, color: '#94a2ad', border: 'none' },
  '.cm-activeLine, .cm-activeLineGutter': { backgroundColor: 'rgb(255 255 255 / 5%)' },
  '&.cm-focused .cm-selectionBackground, .cm-selectionBackground': { backgroundColor: 'rgb(240 163 94 / 28%) !important' },
  '.cm-matchingBracket': { backgroundColor: 'rgb(240 163 94 / 22%)', outline: 'none' },
  '.cm-foldPlaceholder': { backgroundColor: 'transparent', border: 'none', color: SOFT },
  '.cm-tooltip': { backgroundColor: '#2a343d', color: INK, border: '1px solid rgb(255 255 255 / 15%)', borderRadius: '6px' },
  '.cm-diagnostic-error': { borderLeftColor: '#ff8d7a' },
  // In place of pictures from data: addresses, which the policy of the page refuses.
  '.cm-lint-marker-error': { content: '""', backgroundColor: '#ff8d7a', borderRadius: '50%', transform: 'scale(.7)' },
  '.cm-lintRange-error': { textDecoration: 'underline wavy #ff8d7a', textUnderlineOffset: '3px', backgroundImage: 'none' },
}, { dark: true });

const colours = HighlightStyle.define([
  { tag: tags.propertyName, color: '#9cc7e8' },
  { tag: tags.string, color: '#b5d491' },
  { tag: tags.number, color: '#f0b27a' },
  { tag: [tags.bool, tags.null], color: '#d5a6e0' },
]);

export class Editor {
  // In `host`, an element; `onChange` is called after each change of the text.
  constructor(host, onChange) {
    const root = host.attachShadow({ mode: 'open' });
    const changes = EditorView.updateListener.of((update) => { if (update.docChanged) onChange(); });
    this.extensions = [
      lineNumbers(), foldGutter(), lintGutter(), history(), drawSelection(), indentOnInput(), bracketMatching(), codeFolding(),
      highlightActiveLine(), highlightActiveLineGutter(), json(), syntaxHighlighting(colours), theme, changes,
      EditorView.lineWrapping,
      EditorView.contentAttributes.of({ tabindex: '0', 'aria-label': 'Scene, JSON', 'aria-describedby': 'editor-help' }),
      // Without Tab, which goes on to what follows.
      keymap.of([...defaultKeymap, ...historyKeymap, ...foldKeymap, ...lintKeymap]),
    ];
    this.view = new EditorView({ state: this.#state(''), parent: root, root });
  }
  #state(doc) {
    return EditorState.create({ doc, extensions: this.extensions });
  }

  get state() { return this.view.state; }
  get text() { return this.state.doc.toString(); }
  set text(text) {
    this.view.dispatch({ changes: { from: 0, to: this.state.doc.length, insert: text } });
  }

  // Marks places, [{from, to, message}], and no others.
  mark(marks) {
    const diagnostics = marks.map(({ from, to, message }) => ({ from, to, message, severity: 'error' }));
    this.view.dispatch(setDiagnostics(this.state, diagnostics));
  }
  lineOf(position) {
    return this.state.doc.lineAt(Math.min(position, this.state.doc.length)).number;
  }
  reveal(position) {
    this.view.dispatch({ selection: { anchor: position }, effects: EditorView.scrollIntoView(position, { y: 'center' }) });
    this.view.focus();
  }

  // Writes a string at a pointer; where its object lacks the member, as the first one. False where there is no such object.
  setString(pointer, value) {
    const text = JSON.stringify(value);
    const place = placeOf(pointer, this.state);
    if (place.whole) {
      this.view.dispatch({ changes: { from: place.from, to: place.to, insert: text } });
      return true;
    }
    const cut = pointer.lastIndexOf('/');
    const parent = placeOf(pointer.slice(0, cut), this.state);
    if (!parent.whole || this.state.sliceDoc(parent.from, parent.from + 1) !== '{') return false;
    const empty = /^\{\s*\}$/.test(this.state.sliceDoc(parent.from, parent.to));
    const insert = `"${pointer.slice(cut + 1)}": ${text}${empty ? '' : ', '}`;
    this.view.dispatch({ changes: { from: parent.from + 1, insert } });
    return true;
  }
}
