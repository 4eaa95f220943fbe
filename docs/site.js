/* Formulas written in plain text, as MathML: browsers typeset it by themselves.

A block is one whose lines begin with a number such as (wheel.1). In a sentence a formula is emphasised,
*ψ = θ + α_c*, which any reader of Markdown shows in italics. A slash stays a slash, since in plain
text a quotient ends where the reader sees it. Words stay words. */
'use strict';
(() => {
  const FUNCTIONS = new Set(['sin', 'cos', 'tan', 'sec', 'arctan', 'arcsin', 'sinh', 'exp', 'ln', 'sgn', 'cov', 'mod', 'atan', 'arg', 'var', 'diag']);
  const RAISED = '⁰¹²³⁴⁵⁶⁷⁸⁹⁺⁻ⁿᵀ', LOWERED = '₀₁₂₃₄₅₆₇₈₉₊₋ᵢ', PLAIN = { [RAISED]: '0123456789+−nT', [LOWERED]: '0123456789+−i' };
  const PARTS = {'½': [1, 2], '⅓': [1, 3], '¼': [1, 4]};
  const ACCENTS = {'\u0307': '˙', '\u0308': '¨', '\u0304': '¯', '\u0302': '^'};
  const SIGN = /^[=<>≤≥≈≠+−±∓·×←→∝]$/;
  const escape = (text) => text.replace(/&/g, '&amp;').replace(/</g, '&lt;');
  const row = (inner) => '<mrow>' + inner + '</mrow>';
  const plain = (run, alphabet) => [...run].map((c) => PLAIN[alphabet][alphabet.indexOf(c)]).join('');
  const isWords = (text) => !/[=√∫]/.test(text) &&
    (text.match(/[A-Za-z]{3,}/g) ?? []).some((word) => !FUNCTIONS.has(word)) && !new RegExp('[_^' + RAISED + LOWERED + ']').test(text);

  // the end of a bracket that opens at a place
  const closing = (text, open) => {
    let depth = 0;
    for (let k = open; k < text.length; k++) {
      if ('([{'.includes(text[k])) depth++;
      if (')]}'.includes(text[k]) && --depth === 0) return k;
    }
    return -1;
  };

  const parse = (source) => {
    const text = source.normalize('NFD');
    let k = 0, made = '';
    const take = (pattern) => {
      const found = text.slice(k).match(pattern);
      if (found) k += found[0].length;
      return found && found[0];
    };
    // one letter, number, root or bracket, without what is raised or lowered beside it
    const atom = () => {
      const letter = /^[A-Za-z\u0370-\u03ff]/.test(text[k]);
      if (letter) {
        // behind a letter, number or power it is a product, such as the as of 8m²as
        const word = !/[\p{L}\p{N}]/u.test(text[k - 1] ?? '') && take(/^(?:or|at|as|the|of|to|from|with|by|for|here|day|rad)(?![A-Za-z\u0300-\u036f(_^])/);
        if (word) return '<mtext>' + word + '</mtext>';
        const run = text.slice(k).match(/^[A-Za-z]+/)?.[0] ?? '';
        const name = [...FUNCTIONS].find((each) => run === each);
        if (name) { k += name.length; return '<mi>' + name + '</mi>'; }
        if (run.length > 3) { k += run.length; return '<mtext>' + run + '</mtext>'; }
        if (run === 'dln') { k += 3; return '<mi>d</mi><mspace width="0.1em"/><mi>ln</mi>'; }
        const base = '<mi>' + text[k++] + '</mi>';
        const over = ACCENTS[text[k]];
        if (!over) return base;
        k++;
        return '<mover accent="true">' + base + '<mo>' + over + '</mo></mover>';
      }
      const number = take(/^\d+(?:\.\d+)?/);
      if (number) return '<mn>' + number + '</mn>';
      if (PARTS[text[k]]) {
        const [over, under] = PARTS[text[k++]];
        return '<mfrac><mn>' + over + '</mn><mn>' + under + '</mn></mfrac>';
      }
      if (text[k] === '√') {
        k++;
        if (text[k] !== '(') return '<msqrt>' + (k < text.length ? atom() : '') + '</msqrt>';
        const end = closing(text, k), inner = text.slice(k + 1, end);
        k = end + 1;
        return '<msqrt>' + parse(inner) + '</msqrt>';
      }
      if ('([{'.includes(text[k])) {
        const end = closing(text, k);
        if (end > 0) {
          const inner = text.slice(k + 1, end), [open, close] = [text[k], text[end]];
          k = end + 1;
          return isWords(inner) ? '<mtext>' + escape(open + inner + close) + '</mtext>' :
            row('<mo stretchy="false">' + open + '</mo>' + parse(inner) + '<mo stretchy="false">' + close + '</mo>');
        }
      }
      const set = text[k] === '/' ? ' lspace="0" rspace="0"' : !SIGN.test(text[k]) ? '' :
        k === 0 && text[1] === ' ' ? ' form="infix" lspace="0"' : /^\S/.test(text.slice(k + 1)) ? ' form="prefix"' : ' form="infix"';
      return '<mo stretchy="false"' + set + '>' + escape(text[k++]) + '</mo>';
    };
    while (k < text.length) {
      if (take(/^\s+/)) {
        // a sign has space of its own
        if (!SIGN.test(text[k] ?? '') && !/[=<>≤≥≈≠+−±∓·×←→∝]\s+$/.test(text.slice(0, k))) made += '<mspace width="0.2em"/>';
        continue;
      }
      const base = atom();
      let low = '', high = '';
      for (;;) {
        const raised = take(new RegExp('^[' + RAISED + ']+')), lowered = take(new RegExp('^[' + LOWERED + ']+'));
        const primes = take(/^[′″]+/), under = take(/^_[A-Za-z\u0370-\u03ff0-9_]+(?:\+1)?/);
        if (raised) high += parse(plain(raised, RAISED));
        if (lowered) low += parse(plain(lowered, LOWERED));
        if (primes) high += '<mo>' + primes + '</mo>';
        if (under) {
          const name = under.slice(1).replace(/_/g, ' ');
          low += name.length > 2 && !/\+1$/.test(name) ? '<mtext>' + name + '</mtext>' : parse(name);
        }
        if (text[k] === '^') {
          k++;
          const end = '({'.includes(text[k]) ? closing(text, k) : -1;
          if (end > 0) { high += parse(text.slice(k + 1, end)); k = end + 1; }
          else { const sign = take(/^−/); high += (sign ? '<mo>−</mo>' : '') + atom(); }
        } else if (!(raised || lowered || primes || under)) break;
      }
      made += low && high ? '<msubsup>' + row(base) + row(low) + row(high) + '</msubsup>' :
        low ? '<msub>' + row(base) + row(low) + '</msub>' : high ? '<msup>' + row(base) + row(high) + '</msup>' : base;
    }
    return made;
  };

  const math = (text, style) => '<math display="inline" alttext="' + escape(text).replace(/"/g, '&quot;') + '">' +
    '<mstyle displaystyle="' + style + '">' + parse(text) + '</mstyle></math>';

  // A formula in parts, each after the space before it. A line may end between two of them, and inside
  // <math> it can't: before the signs outside brackets, in a long part also behind a comma, before a slash,
  // behind a bracket, before a word, and before the signs within one bracket. Roots and exponents stay whole.
  const pieces = (text) => {
    let depth = 0, made = [''];
    for (const word of text.trim().split(/\s+/)) {
      if (depth === 0 && SIGN.test(word) && made.at(-1)) made.push('');
      made[made.length - 1] += ' ' + word;
      depth += (word.match(/[(\[{]/g) ?? []).length - (word.match(/[)\]}]/g) ?? []).length;
    }
    return made.flatMap(shorter);
  };
  const shorter = (long) => {
    if (long.length < 20) return [long];
    const made = [], within = [];
    let from = 0;
    for (let k = 0; k < long.length; k++) {
      const [before, next] = [long[k - 1], long.slice(k)];
      const ends = within.length === 0 ?
        before === ',' || next[0] === '/' && !/\d/.test(before) || /^ ?[(√A-Za-z]/.test(next) && /[)}]/.test(before) ||
          isWords(next.match(/^ [^ ]*/)?.[0] ?? '') :
        within.length === 1 && within[0] && / . /.test(next.slice(0, 3)) && SIGN.test(next[1]);
      if (ends && k - from > 7 && next.length > 3) { made.push(long.slice(from, k)); from = k; }
      if ('([{'.includes(next[0])) within.push(next[0] === '(' && before !== '√' && before !== '^');
      if (')]}'.includes(next[0])) within.pop();
    }
    return [...made, long.slice(from)];
  };

  for (const marked of document.querySelectorAll('.md-typeset em')) {
    const text = marked.textContent;
    if (isWords(text) || /^(?:as|at|be|by|do|in|is|it|no|of|on|or|to)$/.test(text)) continue;
    if (/^[a-z]{3,}\.?$/.test(text)) continue;
    const formula = document.createElement('span');
    formula.className = 'formula';
    const set = pieces(text).map((piece) => [piece.match(/^ ?/)[0], math(piece.trim(), false)]);
    // no line ends between a formula and the point or bracket after it, nor begins behind the one before
    const [before, after] = [marked.previousSibling, marked.nextSibling];
    const opens = before?.nodeType === 3 ? before.data.match(/[([]$/)?.[0] ?? '' : '';
    const stops = after?.nodeType === 3 ? after.data.match(/^[.,;:)\]]+/)?.[0] ?? '' : '';
    const whole = (each) => '<span style="white-space: nowrap">' + each + '</span>';
    if (opens) { before.data = before.data.slice(0, -1); set[0][1] = whole(opens + set[0][1]); }
    if (stops) { after.data = after.data.slice(stops.length); set.at(-1)[1] = whole(set.at(-1)[1] + stops); }
    formula.innerHTML = set.map(([space, each]) => space + '<wbr>' + each).join('').trim();
    marked.replaceWith(formula);
  }

  for (const code of document.querySelectorAll('.md-typeset .language-text pre > code')) {
    const lines = code.textContent.trimEnd().split('\n');
    if (!/^\([a-z_]+\.\d+\)/.test(lines[0])) continue;
    const block = document.createElement('div');
    block.className = 'equations';
    for (const line of lines) {
      const [, number, rest] = line.match(/^(\([a-z_]+\.\d+\))?\s*(.*)$/);
      const columns = rest.split(/\s{3,}/).map((each) =>
        isWords(each) ? '<span>' + escape(each) + '</span>' : math(each, true));
      block.insertAdjacentHTML('beforeend', '<div class="equation"><span class="number">' + (number ?? '') + '</span>' +
        '<span class="formula">' + columns.join(' ') + '</span></div>');
    }
    code.closest('.language-text').replaceWith(block);
  }
})();
