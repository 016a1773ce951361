// The two jobs that are marked to be shown side by side, and the bar that says which.
const element = (id) => document.getElementById(id);

export class Pair extends EventTarget {
  #marked = [];  // {id, name}, the one that is shown on the left first

  constructor() {
    super();
    element('pair-clear').addEventListener('click', () => this.#set([]));
  }

  has(id) {
    return this.#marked.some((one) => one.id === id);
  }
  // A third one takes the place of the second.
  toggle(id, name) {
    if (this.has(id)) this.forget(id);
    else this.#set([...this.#marked.slice(0, 1), { id, name }]);
  }
  forget(id) {
    if (this.has(id)) this.#set(this.#marked.filter((one) => one.id !== id));
  }

  #set(marked) {
    this.#marked = marked;
    const [first, second] = marked;
    element('pair').hidden = !first;
    element('pair-text').textContent = !first ? '' : second ? `${first.name}, and ${second.name}` : `${first.name}: mark another one to compare it with.`;
    element('pair-open').hidden = !second;
    if (second) element('pair-open').href = `./?job=${first.id}&with=${second.id}`;
    this.dispatchEvent(new Event('change'));
  }
}
