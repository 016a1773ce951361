// The link to what is on screen.
import { make } from './card.js';

export class Share {
  constructor(card) {
    this.card = card;
    this.field = make('input', { readOnly: true, id: 'share-link' });
    this.field.setAttribute('aria-label', 'Link to this view');
    this.said = make('p', {});
    this.said.setAttribute('role', 'status');
    card.append(this.field, this.said);
  }

  // Keeps to what is on screen while the card is open.
  update(address) {
    if (this.card.hidden || this.field.value === address) return;
    this.field.value = address;
    this.said.textContent = 'The view has changed: copy it anew.';
  }
  // Copies the address; where the browser refuses, it can be copied by hand.
  async show(address) {
    this.card.hidden = false;
    this.field.value = address;
    this.field.select();
    try {
      await navigator.clipboard.writeText(address);
      this.said.textContent = 'Copied.';
    } catch {
      this.said.textContent = 'Copy it from here.';
    }
  }
}
