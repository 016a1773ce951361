// Whether a key that was pressed is meant for the whole page: not where it is typed into a field or where a dialog is open.
export function isShortcut(event) {
  if (event.ctrlKey || event.metaKey || event.altKey || document.querySelector('dialog[open]')) return false;
  return !event.target.matches?.('input:not([type=range], [type=radio], [type=checkbox]), textarea');
}
// Whether it is an arrow that a control which has the focus takes for itself.
export const isTaken = ({ target }) => Boolean(target.matches?.('input, select'));
