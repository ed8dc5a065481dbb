// SPDX-License-Identifier: GPL-3.0-or-later
// A table that does not prove what its numbers are: its columns, and a button for each likely reading. They stay when one
// is chosen, so that another can be tried. (element, headCell, rowOf, scrollPlace: report's text.js)
const host = document.getElementById('question');

export function hideQuestion() {
  host.replaceChildren();
  host.hidden = true;
}

/// @param choose  is given the options that tell the reading
export function showQuestion({columns, readings}, choose) {
  const again = host.contains(document.activeElement);  // a second question, by keyboard
  const place = scrollPlace('Columns of the table');
  place.append(element('table', {}, element('thead', {}, element('tr', {}, ['column', 'first cells'].map(headCell))),
                       element('tbody', {}, columns.map(({title, first_cells}) => rowOf([title, `${first_cells} …`])))));
  const buttons = readings.map(({meaning, options}) => {
    const button = element('button', {type: 'button', 'aria-pressed': 'false'}, meaning);
    button.addEventListener('click', () => {
      for (const other of buttons) other.setAttribute('aria-pressed', String(other === button));
      choose(options);
    });
    return button;
  });
  host.replaceChildren(...(columns.length ? [place] : []), element('div', {class: 'impacts', role: 'group', 'aria-label': 'What it is'}, buttons));
  host.hidden = false;
  if (again) buttons[0].focus();
  for (const node of [host, document.getElementById('status')]) node.scrollIntoView({block: 'nearest'});
}
