(() => {
  const data = JSON.parse(document.getElementById('data').textContent);
  const { variables, sasi, spi, classes, choices } = data;
  const diagram = Diagram(data.nodes, data.width);
  const maps = ['sasi', 'spi', 'classes'].map((name) => {
    const figure = document.getElementById('map-' + name);
    return { name, figure, cells: [...figure.querySelectorAll('.cell')], token: figure.querySelector('.token'), mark: figure.querySelector('rect.chosen') };
  });
  const inPlane = (index) => index === data.row || index === data.column;
  const view = data.opening.slice();
  let chosen = null;
  let step = null;

  const show = (variable, value) => (variable.bool ? String(value !== 0) : String(value));

  /** Rank 2, 2+ or ∞ of a ladder. */
  function rank(ladder, pattern) {
    if (ladder.unbounded !== null && diagram.meets(ladder.unbounded, pattern)) {
      return { text: '∞', color: ladder.unboundedColor };
    }
    let k = 0;
    while (k < ladder.levels.length && diagram.meets(ladder.levels[k], pattern)) k += 1;
    const more = ladder.open && k === ladder.levels.length ? '+' : '';
    return { text: k + more, color: ladder.colors[k] };
  }

  function classOf(pattern) {
    const found = classes.filter((c) => diagram.meets(c.edge, pattern));
    if (found.length === 1) return { text: found[0].mark, color: found[0], found };
    return { text: '…', color: { fill: 'var(--several)', ink: 'var(--ink)' }, found };
  }

  function placed(row, column) {
    const at = view.slice();
    if (data.row !== null) at[data.row] = row;
    at[data.column] = column;
    return at;
  }

  const isOpen = () => view.some((value, index) => value === null && !inPlane(index));

  function permitted(ladder, pattern) {
    return choices.filter((_, number) => diagram.meets(ladder.permitted[number], pattern));
  }

  function arrows(ladder, pattern) {
    return [...new Set(permitted(ladder, pattern).map((choice) => choice.arrow))].join('');
  }

  // Cells in which no state can be, whatever the other values are, look like walls.
  const walls = new Map();
  const key = (row, column) => row + ',' + column;
  for (const row of data.rows) {
    for (const column of data.columns) {
      const anywhere = variables.map(() => null);
      if (data.row !== null) anywhere[data.row] = row;
      anywhere[data.column] = column;
      walls.set(key(row, column), !diagram.meets(data.scope, diagram.pattern(variables, anywhere)));
    }
  }

  // The maps have the same cells in the same order, so each is looked up once for all.
  const places = maps[0].cells.map((cell, index) => ({
    row: Number(cell.dataset.row),
    column: Number(cell.dataset.col),
    parts: maps.map((map) => map.cells[index]),
  }));

  function draw() {
    const open = isOpen();
    for (const { row, column, parts } of places) {
      const pattern = diagram.pattern(variables, placed(row, column));
      if (!diagram.meets(data.scope, pattern)) {
        const fill = walls.get(key(row, column)) ? 'url(#wall)' : 'var(--void)';
        for (const cell of parts) paint(cell, { text: '', color: { fill, ink: 'currentColor' } }, '');
        continue;
      }
      paint(parts[0], rank(sasi, pattern), open ? '' : arrows(sasi, pattern));
      paint(parts[1], rank(spi, pattern), open ? '' : arrows(spi, pattern));
      paint(parts[2], classOf(pattern), '');
    }
    describeView(open);
    describeCell(open);
    drawMarks();
    drawPlay();
  }

  /** Shows what was found; small cells have a colour and nothing else. */
  function paint(cell, found, path) {
    cell.dataset.value = found.text;
    for (const part of cell.children) {
      if (part.localName === 'rect') {
        part.setAttribute('fill', found.color.fill);
        continue;
      }
      part.setAttribute('fill', found.color.ink);
      if (part.localName === 'path') part.setAttribute('d', path);
      if (!part.classList.contains('value')) continue;
      part.textContent = found.text;
      part.classList.toggle('long', [4, 5].includes(found.text.length));
      part.classList.toggle('longer', found.text.length > 5);
    }
  }

  /** The upper left corner of a cell in its drawing. */
  function corner(map, row, column) {
    const cell = map.cells.find((c) => Number(c.dataset.row) === row && Number(c.dataset.col) === column);
    return cell ? cell.getAttribute('transform').match(/[\d.]+/g).map(Number) : null;
  }

  function drawMarks() {
    for (const map of maps) {
      const place = chosen && corner(map, chosen.row, chosen.column);
      map.mark.setAttribute('visibility', place ? 'visible' : 'hidden');
      if (!place) continue;
      map.mark.setAttribute('x', place[0]);
      map.mark.setAttribute('y', place[1]);
    }
  }

  function describeView(open) {
    const others = variables.map((v, i) => [v, i]).filter(([v, i]) => !inPlane(i) && v.low < v.high);
    if (!document.querySelector('.controls')) return;
    const texts = others.map(([v, i]) => (view[i] === null ? 'any ' + v.name : v.name + '=' + show(v, view[i])));
    const line = document.getElementById('view');
    const all = others.every(([, i]) => view[i] === null) && variables.length > 3;
    line.textContent = 'For ' + (all ? 'any values of the other variables' : texts.join(', ')) + (open ? ': the most that some value allows.' : '.');
    line.dataset.open = open;
  }

  function describeCell(open) {
    const box = document.getElementById('cell');
    if (chosen === null) return;
    const at = placed(chosen.row, chosen.column);
    const pattern = diagram.pattern(variables, at);
    const state = variables.map((v, i) => (at[i] === null ? 'any ' + v.name : v.name + '=' + show(v, at[i])));
    box.replaceChildren();
    const title = document.createElement('code');
    title.textContent = state.join(',');
    box.append(title);
    const list = document.createElement('dl');
    const line = (term, text) => {
      const [dt, dd] = [document.createElement('dt'), document.createElement('dd')];
      dt.textContent = term;
      dd.textContent = text;
      list.append(dt, dd);
    };
    if (!diagram.meets(data.scope, pattern)) {
      line('state', walls.get(key(chosen.row, chosen.column)) ? 'never: no play comes here' : 'no play comes here with these values');
    } else {
      const sure = classOf(pattern);
      line('sure of', sure.found.map((c) => c.name).join(' / '));
      describeRank(line, 'guaranteed', sasi, pattern, open);
      describeRank(line, 'possible', spi, pattern, open);
      const here = data.objectives.filter((_, i) => diagram.meets(data.targets[i], pattern));
      if (here.length) line('target of', here.join(', '));
    }
    box.append(list);
  }

  function describeRank(line, name, ladder, pattern, open) {
    const names = [...new Set(permitted(ladder, pattern).map((choice) => choice.name))];
    const actions = names.length && !open ? '; permitted: ' + names.join(', ') : '';
    line(name, rank(ladder, pattern).text + (open ? ' at most' : '') + actions);
  }

  // Sliders and boxes.
  const controls = [...document.querySelectorAll('.control')].map((box) => {
    const index = variables.findIndex((v) => v.name === box.dataset.variable);
    const [input, any] = [box.querySelector('input[type=range], select'), box.querySelector('.any input')];
    const change = (open) => {
      any.checked = open;
      view[index] = open ? null : Number(input.value);
      step = null;
      settle();
    };
    input.addEventListener('input', () => change(false));
    any.addEventListener('change', () => change(any.checked));
    return { box, index, input, any, output: box.querySelector('output') };
  });

  function settle() {
    for (const { box, index, input, any, output } of controls) {
      const value = view[index];
      any.checked = value === null;
      box.classList.toggle('open', value === null);
      if (value !== null) input.value = value;
      if (output) output.textContent = value === null ? 'any' : input.value;
    }
    draw();
    remember();
  }

  function setAll(value) {
    variables.forEach((_, index) => { if (!inPlane(index)) view[index] = value(index); });
    step = null;
    settle();
  }
  document.getElementById('to-start')?.addEventListener('click', () => setAll((index) => data.at[index]));
  document.getElementById('to-any')?.addEventListener('click', () => setAll(() => null));

  for (const map of maps) {
    map.figure.addEventListener('click', (event) => {
      const cell = event.target.closest('.cell');
      if (!cell) return;
      chosen = { row: Number(cell.dataset.row), column: Number(cell.dataset.col) };
      draw();
      remember();
    });
  }

  // The play.
  const rows = [...document.querySelectorAll('.turns tr[data-turn]')];
  const last = data.play.length - 1;

  function go(to) {
    step = Math.max(0, Math.min(last, to));
    if (!data.projected) data.play[step].forEach((value, index) => { if (!inPlane(index)) view[index] = value; });
    chosen = { row: data.row === null ? 0 : data.play[step][data.row], column: data.play[step][data.column] };
    settle();
  }

  function drawPlay() {
    for (const row of rows) {
      const now = Number(row.dataset.turn) === step;
      row.classList.toggle('now', now);
      const box = row.closest('.scroll');
      if (now) box.scrollTop = row.offsetTop - box.clientHeight / 2;
    }
    const label = document.getElementById('step');
    if (label) label.textContent = step === null ? 'not begun' : step === 0 ? 'start' : 'step ' + step + ' of ' + last;
    for (const map of maps) {
      const state = step === null ? null : data.play[step];
      const place = state && corner(map, data.row === null ? 0 : state[data.row], state[data.column]);
      map.token.setAttribute('visibility', place ? 'visible' : 'hidden');
      if (!place) continue;
      map.token.setAttribute('cx', place[0] + 20);
      map.token.setAttribute('cy', place[1] + 20);
    }
  }

  if (last > 0) {
    document.querySelector('.stepper').hidden = false;
    const moves = { first: () => 0, back: () => (step ?? 1) - 1, on: () => (step ?? -1) + 1, last: () => last };
    for (const button of document.querySelectorAll('[data-step]')) {
      button.addEventListener('click', () => go(moves[button.dataset.step]()));
    }
    for (const row of rows) row.addEventListener('click', () => go(Number(row.dataset.turn)));
  }

  // The address remembers the view, so that a link leads to it: #b=8&d=false&cell=2,3 or #step=4.
  function remember() {
    const parts = step !== null ? ['step=' + step] : controls.map(({ index }) => {
      const variable = variables[index];
      return variable.name + '=' + (view[index] === null ? 'any' : show(variable, view[index]));
    });
    if (chosen !== null && step === null) parts.push('cell=' + chosen.row + ',' + chosen.column);
    try {
      history.replaceState(null, '', '#' + parts.join('&'));
    } catch {
      // Some viewers of files allow no history: then there is no link.
    }
  }

  function recall() {
    let play = null;
    for (const part of decodeURIComponent(location.hash.slice(1)).split('&')) {
      const [name, value] = part.split('=');
      const index = variables.findIndex((v) => v.name === name);
      if (name === 'cell') {
        const [row, column] = value.split(',').map(Number);
        chosen = { row, column };
      } else if (name === 'step') {
        play = Number(value);
      } else if (index >= 0 && !inPlane(index) && !data.projected) {
        const number = value === 'true' ? 1 : value === 'false' ? 0 : Number(value);
        const { low, high } = variables[index];
        if (value === 'any') view[index] = null;
        else if (Number.isInteger(number) && low <= number && number <= high) view[index] = number;
      }
    }
    if (play !== null && last > 0) go(play);
    else settle();
  }

  window.addEventListener('hashchange', recall);
  if (location.hash.length > 1) recall();
  else settle();
})();
