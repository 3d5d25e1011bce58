(() => {
  const data = JSON.parse(document.getElementById('data').textContent);
  const { variables, sasi, spi, classes, choices, game } = data;
  const diagram = Diagram(data.nodes, data.width);
  const measures = data.heat ? data.heat.measures : [];
  const maps = ['sasi', 'spi', 'classes', ...measures.map((m) => m.id)].map((name) => {
    const figure = document.getElementById('map-' + name);
    return { name, figure, cells: [...figure.querySelectorAll('.cell')], token: figure.querySelector('.token'), mark: figure.querySelector('.chosen'), pieces: [...figure.querySelectorAll('.piece')] };
  });
  const inPlane = (index) => index === data.row || index === data.column;
  const view = data.opening.slice();
  let chosen = null;
  let step = null;

  const show = (variable, value) => variable.names[value - variable.low] ?? (variable.bool ? String(value !== 0) : String(value));

  /** Returns a value as people read it: x=1, or the fact of a planning problem. */
  function reading(variable, value) {
    const { facts } = variable;
    if (facts[value - variable.low]) return facts[value - variable.low];
    return variable.bool && facts[1] ? 'not ' + facts[1] : variable.name + '=' + show(variable, value);
  }

  /** Returns the name of a rank: 2, 2+ or ∞. */
  function mark(ladder, k) {
    const last = k === ladder.levels.length;
    return last && ladder.unbounded !== null ? '∞' : k + (last && ladder.open ? '+' : '');
  }

  /** Returns the rank of a ladder. */
  function rank(ladder, pattern) {
    if (ladder.unbounded !== null && diagram.meets(ladder.unbounded, pattern)) {
      return { text: '∞', color: ladder.unboundedColor };
    }
    let k = 0;
    while (k < ladder.levels.length && diagram.meets(ladder.levels[k], pattern)) k += 1;
    return { text: mark(ladder, k), color: ladder.colors[k] };
  }

  /** Returns the players of a game that choose in some states of a pattern. */
  const movers = (pattern) => (game ? game.players.filter((player) => diagram.meets(player.edge, pattern)) : []);

  function isTheirs(pattern) {
    const all = movers(pattern);
    return all.length > 0 && all.every((player) => !player.ours);
  }

  function classOf(pattern) {
    const found = classes.filter((c) => diagram.meets(c.edge, pattern));
    if (found.length === 1) return { text: found[0].mark, color: found[0], found };
    return { ...squares(found), color: { fill: 'var(--several)', ink: 'var(--ink)' }, found };
  }

  /** Returns the text and the colours of a square per class; the last one stands for all others. */
  function squares(found) {
    const fills = found.slice(0, data.squares).map((c) => c.fill);
    if (found.length <= data.squares) return { text: '■'.repeat(fills.length), fills };
    fills[data.squares - 1] = 'currentColor';
    return { text: '■'.repeat(data.squares - 1) + '+', fills };
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

  /** Returns the label of a choice; with its commands, where several choices with the label are enabled. */
  function nameOf(choice, pattern) {
    return choice.several !== null && diagram.meets(choice.several, pattern) ? choice.own : choice.name;
  }

  function arrows(ladder, pattern) {
    return [...new Set(permitted(ladder, pattern).map((choice) => choice.arrow))].join('');
  }

  // The values of all states, by their place in the plane.
  const placeOf = (row, column) => row + ',' + column;
  const valued = new Map();
  for (const [number, state] of (data.heat ? data.heat.states : []).entries()) {
    const key = placeOf(data.row === null ? 0 : state[data.row], state[data.column]);
    if (!valued.has(key)) valued.set(key, []);
    valued.get(key).push(number);
  }

  /** Returns the look of the best value of the states of a cell; `others` are values or null for any. */
  function best(measure, row, column, others) {
    let found = measure.looks.length - 1;
    for (const number of valued.get(placeOf(row, column)) ?? []) {
      const state = data.heat.states[number];
      if (others.every((wanted, i) => wanted === null || inPlane(i) || wanted === state[i])) found = Math.min(found, measure.all[number]);
    }
    return { text: measure.looks[found].text, color: measure.looks[found] };
  }

  /** Returns the pattern of a cell in which the other variables have any values. */
  function anywhere(row, column) {
    const open = variables.map(() => null);
    if (data.row !== null) open[data.row] = row;
    open[data.column] = column;
    return diagram.pattern(variables, open);
  }

  /** Returns the states that a cell shows: safe ones with these values, or unsafe ones, or those with other values. */
  function located(here, anywhere) {
    for (const [elsewhere, pattern] of [[false, here], [true, anywhere]]) {
      if (diagram.meets(data.scope, pattern)) return { pattern, elsewhere, unsafe: false };
      if (data.unsafe && diagram.meets(data.unsafe.edge, pattern)) return { pattern, elsewhere, unsafe: true };
    }
    return null;
  }

  // The maps have the same cells in the same order, so one lookup serves all maps.
  const places = maps[0].cells.map((cell, index) => ({
    row: Number(cell.dataset.row),
    column: Number(cell.dataset.col),
    parts: maps.map((map) => map.cells[index]),
    anywhere: anywhere(Number(cell.dataset.row), Number(cell.dataset.col)),
  }));

  /** Finds the marks of each cell; one that more than half of the cells have is left out. */
  function findMarks() {
    const live = places.filter((place) => place.states !== null);
    for (const place of places) place.marks = [];
    data.marks.forEach((mark, number) => {
      const [own, pale] = [[], []];
      for (const place of live) {
        if (!place.states.elsewhere && diagram.meets(mark.edge, place.states.pattern)) own.push(place);
        else if (!mark.wide && diagram.meets(mark.edge, place.anywhere)) (place.states.elsewhere ? own : pale).push(place);
      }
      const some = 2 * (own.length + pale.length) <= live.length;
      if (2 * own.length <= live.length) for (const place of own) place.marks.push({ number, pale: false });
      if (some) for (const place of pale) place.marks.push({ number, pale: true });
    });
    for (const entry of document.querySelectorAll('.key [data-mark]')) entry.hidden = !live.some((place) => place.marks.some((mark) => mark.number === Number(entry.dataset.mark)));
    for (const entry of document.querySelectorAll('.key .faint')) entry.hidden = !live.some((place) => place.marks.some((mark) => mark.pale));
    for (const entry of document.querySelectorAll('.key .crowded')) entry.hidden = !live.some((place) => place.marks.length > 4);
    // Signs in most of the small cells would only hide their values.
    document.body.classList.toggle('filled', 2 * live.filter((place) => place.marks.length > 0).length > live.length);
    nameSmall();
  }

  /** Names the sign of small cells, if there is one. */
  function nameSmall() {
    const entry = document.querySelector('.key .small');
    const shown = !document.body.classList.contains('filled') && (document.querySelector('.tiny') || (document.querySelector('.middle') && places.some((place) => place.marks.length > 1)));
    if (entry) entry.hidden = !shown;
  }

  function draw() {
    const open = isOpen();
    for (const place of places) {
      // If no state has these values, the cell is faded and shows the best over all others.
      place.states = located(diagram.pattern(variables, placed(place.row, place.column)), place.anywhere);
    }
    findMarks();
    for (const place of places) {
      const states = place.states;
      place.several = false;
      place.theirs = states !== null && isTheirs(states.pattern);
      if (states === null) {
        place.parts.forEach((_, map) => paint(place, map, { text: '', color: { fill: 'url(#wall)', ink: 'currentColor' } }, '', false));
        continue;
      }
      const { pattern, elsewhere } = states;
      if (states.unsafe) {
        place.parts.forEach((_, map) => paint(place, map, { text: data.unsafe.text, color: data.unsafe, unsafe: true }, '', elsewhere));
        continue;
      }
      const still = open || elsewhere;
      paint(place, 0, rank(sasi, pattern), still ? '' : arrows(sasi, pattern), elsewhere);
      paint(place, 1, rank(spi, pattern), still ? '' : arrows(spi, pattern), elsewhere);
      const preferred = classOf(pattern);
      place.several = preferred.found.length > 1;
      paint(place, 2, preferred, '', elsewhere);
      const others = elsewhere ? view.map(() => null) : view;
      measures.forEach((m, i) => paint(place, 3 + i, best(m, place.row, place.column, others), '', elsewhere));
    }
    describeView(open);
    describeCell(open);
    drawMarks();
    drawPlay();
  }

  /** Shows the results of a cell; small cells have only a colour. */
  function paint(place, map, found, path, elsewhere) {
    const cell = place.parts[map];
    cell.dataset.value = elsewhere ? '' : found.text;
    cell.classList.toggle('elsewhere', elsewhere);
    cell.classList.toggle('theirs', place.theirs);
    cell.setAttribute('aria-label', spoken(place, map, found, elsewhere));
    markCell(cell, place.marks);
    for (const part of cell.children) {
      if (part.localName === 'g') continue;
      if (part.localName === 'title') {
        part.textContent = cell.getAttribute('aria-label');
        continue;
      }
      if (part.localName === 'rect') {
        part.setAttribute('fill', found.color.fill);
        if (game) part.setAttribute('rx', place.theirs ? game.round : 0);
        continue;
      }
      part.setAttribute('fill', found.color.ink);
      if (part.localName === 'path') part.setAttribute('d', path);
      if (!part.classList.contains('value')) continue;
      part.classList.toggle('squares', Boolean(found.fills));
      if (found.fills) {
        part.replaceChildren(...found.fills.map((fill, i) => square(fill, found.text[i])));
        continue;
      }
      part.textContent = found.text;
      if (part.hasAttribute('stroke')) part.setAttribute('stroke', found.color.fill);
      for (let size = 0; size < 5; size += 1) part.classList.toggle('s' + size, size === (found.color.size ?? (found.text.length > 2 ? 1 : 0)));
    }
  }

  /** Returns an element of a drawing. */
  function shape(name, attributes, ...content) {
    const part = document.createElementNS('http://www.w3.org/2000/svg', name);
    for (const [key, value] of Object.entries(attributes)) part.setAttribute(key, value);
    part.append(...content);
    return part;
  }

  const square = (fill, text) => shape('tspan', { fill }, text);

  /** Draws the marks of a cell, if they changed: targets from the first corner on, labels from the last. */
  function markCell(cell, marks) {
    const known = cell.querySelector('.marks');
    const all = marks.map(({ number, pale }) => number + (pale ? 'p' : '')).join() || 'none';
    if ((cell.dataset.marks ?? (known ? '' : 'none')) === all) return;
    cell.dataset.marks = all;
    known?.remove();
    if (marks.length === 0) return;
    const glyphs = marks.slice(0, marks.length > 4 ? 3 : 4).map(({ number }) => data.marks[number].glyph).concat(marks.length > 4 ? ['+'] : []);
    const targets = marks.length > 4 ? 4 : marks.filter(({ number }) => data.marks[number].target).length;
    const paler = (class_, pale) => (pale ? class_ + ' pale' : class_);
    const corners = glyphs.map((glyph, i) => {
      const corner = i < targets ? i : 3 - (i - targets);
      return shape('tspan', { class: paler(corner % 2 ? 'end' : '', glyph !== '+' && marks[i].pale), x: corner % 2 ? 37 : 3, y: corner < 2 ? 11 : 36 }, glyph);
    });
    const label = targets === 0 || (marks.length > 4 && marks.every(({ number }) => !data.marks[number].target));
    const pale = marks.every((mark) => mark.pale);
    const single = marks.length === 1 ? glyphs[0] : label ? '•' : '◆';
    (cell.querySelector('.start') ?? cell.querySelector('rect')).after(shape('g', { class: 'marks' }, shape('text', { class: 'corners' }, ...corners),
      shape('text', { class: paler(single.length > 1 ? 'single pair' : 'single', pale), x: 20, y: 29 }, single),
      shape('path', { class: paler('dot', pale), d: data.dots[Number(label)] })));
  }

  const named = ({ found }) => found.map((c) => c.name).join('; ');

  /** Returns the text of a cell for screen readers. */
  function spoken({ row, column, theirs }, map, found, elsewhere) {
    const place = (data.row === null ? '' : reading(variables[data.row], row) + ', ') + reading(variables[data.column], column);
    if (found.text === '') return place + ': unreachable';
    if (found.unsafe) return place + ': unsafe' + (elsewhere ? ', with other values' : '');
    const what = map > 2 ? measures[map - 3].title + ': ' + found.text : map === 2 ? 'most preferred: ' + named(found) : found.text + (map === 0 ? ' guaranteed' : ' possible');
    return place + ': ' + (theirs ? 'the opponent moves; ' : '') + what + (elsewhere ? ' at best, with other values' : '');
  }

  /** Returns the upper left corner of a cell in its drawing. */
  function corner(map, row, column) {
    const cell = map.cells.find((c) => Number(c.dataset.row) === row && Number(c.dataset.col) === column);
    return cell ? cell.getAttribute('transform').match(/[\d.]+/g).map(Number) : null;
  }

  function drawMarks() {
    for (const map of maps) {
      const place = chosen && corner(map, chosen.row, chosen.column);
      map.mark.setAttribute('visibility', place ? 'visible' : 'hidden');
      if (place) map.mark.setAttribute('transform', 'translate(' + place + ')');
    }
    for (const map of maps) map.pieces.forEach((piece) => drawPiece(map, piece));
  }

  /** Moves the sign of another player to the place that the view gives it. */
  function drawPiece(map, piece) {
    const [row, column] = [view[piece.dataset.row], view[piece.dataset.col]];
    const place = row === null || column === null ? null : corner(map, row, column);
    piece.setAttribute('visibility', place ? 'visible' : 'hidden');
    if (place) piece.setAttribute('transform', 'translate(' + place + ')');
  }

  function describeView(open) {
    const others = variables.map((v, i) => [v, i]).filter(([v, i]) => !inPlane(i) && v.low < v.high);
    if (!document.querySelector('.controls')) return;
    const texts = others.map(([v, i]) => (view[i] === null ? 'any ' + v.name : reading(v, view[i])));
    const line = document.getElementById('view');
    const all = others.every(([, i]) => view[i] === null) && variables.length > 3;
    const pale = places.some((place) => place.parts[0].classList.contains('elsewhere'));
    document.querySelector('.legend .several').hidden = !places.some((place) => place.several);
    line.textContent = 'For ' + (all ? 'any values of the other variables' : texts.join(', ')) + (open ? ': each cell shows the best of these.' : '.')
      + (pale ? ' Faded cells are unreachable with these values; they show the best over all others.' : '');
    line.dataset.open = open;
  }

  function describeCell(open) {
    const box = document.getElementById('cell');
    if (chosen === null) return;
    const at = placed(chosen.row, chosen.column);
    const pattern = diagram.pattern(variables, at);
    const state = variables.map((v, i) => (at[i] === null ? 'any ' + v.name : reading(v, at[i])));
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
      return dd;
    };
    const states = located(pattern, anywhere(chosen.row, chosen.column));
    if (states === null) {
      line('state', 'unreachable');
    } else if (states.unsafe) {
      if (states.elsewhere) line('state', 'unreachable with these values; with others:');
      line('unsafe', 'no strategy keeps the requirements');
    } else {
      const { pattern: there, elsewhere } = states;
      if (elsewhere) line('state', 'unreachable with these values; with others:');
      describeMovers(line, there);
      const preferred = classOf(there);
      line('most preferred', named(preferred) + (preferred.found.length > 1 ? ' (depends on the other values)' : ''));
      describeRank(line, 'guaranteed', sasi, there, open || elsewhere);
      describeRank(line, 'possible', spi, there, open || elsewhere);
      const here = data.objectives.filter((_, i) => diagram.meets(data.targets[i], there));
      const others = elsewhere ? view.map(() => null) : view;
      for (const measure of measures) line(measure.title.toLowerCase(), best(measure, chosen.row, chosen.column, others).text);
      if (here.length) line('target of', here.join(', '));
    }
    const any = diagram.pattern(variables, variables.map((_, i) => (i === data.row ? chosen.row : i === data.column ? chosen.column : null)));
    const labels = data.labels.filter((label) => diagram.meets(label.edge, any)).map((label) => label.name);
    if (labels.length) line('labels', labels.join(', '));
    box.append(list);
    if (states && !states.unsafe && !states.elsewhere && !open && game && game.moves.length && isTheirs(states.pattern)) box.append(movesTable(states.pattern));
  }

  function describeMovers(line, pattern) {
    const all = movers(pattern);
    if (all.length === 0) return;
    const theirs = isTheirs(pattern);
    const shown = line('to move', all.map((player) => player.name).join(' or ') + (theirs ? ', the opponent' : all.every((player) => player.ours) ? ', ours' : ''));
    if (theirs || all.every((player) => player.ours)) shown.className = 'who ' + (theirs ? 'theirs' : 'ours');
  }

  /** Lists what each move of the opponent leads to. */
  function movesTable(pattern) {
    const table = document.createElement('table');
    table.className = 'moves';
    const row = (tag, texts) => {
      const line = document.createElement('tr');
      line.append(...texts.map((text) => Object.assign(document.createElement(tag), { textContent: text })));
      table.append(line);
    };
    row('th', ['move', 'guaranteed after it', 'possible after it', 'effect']);
    const after = (ladder, edges) => edges.map((edge, k) => (diagram.meets(edge, pattern) ? mark(ladder, k) : null)).filter((text) => text !== null).join(' or ');
    const effect = (verb, [surely, possibly]) => (diagram.meets(surely, pattern) ? [verb + 's'] : diagram.meets(possibly, pattern) ? ['may ' + verb] : []);
    for (const move of game.moves.filter((each) => diagram.meets(each.enabled, pattern))) {
      const effects = [...effect('improve', move.improves), ...effect('weaken', move.weakens)];
      row('td', [nameOf(choices[move.choice], pattern), after(sasi, move.sasi), after(spi, move.spi), effects.join(', ') || 'neither improves nor weakens']);
    }
    return table;
  }

  function describeRank(line, name, ladder, pattern, open) {
    const names = [...new Set(permitted(ladder, pattern).map((choice) => nameOf(choice, pattern)))];
    // The only choice of a state of a Markov chain has no name of its own.
    const actions = names.length && !open && !data.chain ? '; permitted: ' + names.join(', ') : '';
    line(name, rank(ladder, pattern).text + (open ? ' at best' : '') + actions);
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

  function choose(place) {
    chosen = { row: place.row, column: place.column };
    draw();
    remember();
  }

  // In each map the tab key reaches one cell, and the arrow keys the others.
  function goTo(index, map) {
    places.forEach((place, i) => place.parts[map].setAttribute('tabindex', i === index ? 0 : -1));
  }

  const ways = { ArrowLeft: [0, -1], ArrowRight: [0, 1], ArrowUp: [-1, 0], ArrowDown: [1, 0] };
  maps.forEach((map, number) => {
    const wide = data.columns.length;
    const indexOf = (event) => map.cells.indexOf(event.target.closest('.cell'));
    map.figure.querySelector('.drawing svg').setAttribute('role', 'group');
    for (const cell of map.cells) cell.setAttribute('role', 'button');
    goTo(Math.max(0, places.findIndex((p) => p.column === data.at[data.column] && (data.row === null || p.row === data.at[data.row]))), number);
    map.figure.addEventListener('click', (event) => {
      const index = indexOf(event);
      if (index < 0) return;
      goTo(index, number);
      choose(places[index]);
    });
    map.figure.addEventListener('keydown', (event) => {
      const index = indexOf(event);
      if (index < 0) return;
      const way = ways[event.key];
      if (way) {
        const [row, column] = [Math.floor(index / wide) + way[0], (index % wide) + way[1]];
        const to = row * wide + column;
        if (row >= 0 && row < data.rows.length && column >= 0 && column < wide) {
          goTo(to, number);
          map.cells[to].focus();
        }
      } else if (event.key === 'Enter' || event.key === ' ') {
        choose(places[index]);
      } else {
        return;
      }
      event.preventDefault();
    });
  });

  // The run.
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
    }
    const label = document.getElementById('step');
    if (label) {
      label.textContent = step === null ? 'not started' : step === 0 ? 'start' : 'step ' + step + ' of ' + last;
      const next = step === null || data.projected ? [] : movers(diagram.pattern(variables, data.play[step]));
      const side = document.getElementById('turn');
      if (side) {
        side.className = next.length === 0 ? '' : 'who ' + (next[0].ours ? 'ours' : 'theirs');
        side.textContent = next.length === 0 ? '' : next[0].name + ' moves';
      }
    }
    for (const map of maps) {
      const state = step === null ? null : data.play[step];
      const place = state && corner(map, data.row === null ? 0 : state[data.row], state[data.column]);
      map.token.setAttribute('visibility', place ? 'visible' : 'hidden');
      if (!place) continue;
      map.token.setAttribute('transform', 'translate(' + place + ')');
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

  // What would be too small to read is left out.
  const watch = new ResizeObserver((entries) => {
    for (const { target, contentRect } of entries) {
      const side = contentRect.width / data.columns.length;
      target.classList.toggle('middle', side < data.sides.middle);
      target.classList.toggle('tiny', side < data.sides.tiny);
      target.classList.toggle('colors', side < Number(target.dataset.readable));
      for (const axis of target.querySelectorAll('.axis')) axis.classList.toggle('coarse', side < Number(axis.dataset.least));
    }
    nameSmall();
  });
  for (const map of maps) watch.observe(map.figure.querySelector('.drawing'));

  // The address contains the view, so that a link opens it: #b=8&d=false&cell=2,3 or #step=4.
  function remember() {
    const parts = step !== null ? ['step=' + step] : controls.map(({ index }) => {
      const variable = variables[index];
      return variable.name + '=' + (view[index] === null ? 'any' : show(variable, view[index]));
    });
    if (chosen !== null && step === null) parts.push('cell=' + chosen.row + ',' + chosen.column);
    try {
      history.replaceState(null, '', '#' + parts.join('&'));
    } catch {
      // Some viewers of local files do not allow this.
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
        const { low, high, names } = variables[index];
        const named = names.indexOf(value);
        const number = named >= 0 ? low + named : value === 'true' ? 1 : value === 'false' ? 0 : Number(value);
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
