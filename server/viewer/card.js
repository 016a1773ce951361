// The cards in which tools tell what they found.

const fine = new Intl.NumberFormat('en', { minimumFractionDigits: 2, maximumFractionDigits: 2 });
export const metres = (value) => `${fine.format(value)} m`;

// Little room beside the panel, as in style.css: it and the cards begin folded.
export const isNarrow = () => matchMedia('(max-width: 720px)').matches;

export function make(tag, properties = {}, ...children) {
  const element = Object.assign(document.createElement(tag), properties);
  element.append(...children);
  return element;
}

// Fills a <dl> with pairs of a name and a text, an element or null (which leaves the row out).
export function fillRows(list, rows) {
  list.replaceChildren(...rows.filter(([, value]) => value !== null && value !== undefined)
    .flatMap(([name, value]) => [make('dt', {}, name), make('dd', {}, value)]));
}
