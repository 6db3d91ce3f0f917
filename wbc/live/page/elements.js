// Elements of the page, number formatting and sliders.
"use strict";
(() => {
function make(tag, attributes = {}, ...children) {
  const node = document.createElement(tag);
  Object.assign(node, attributes);
  node.append(...children);
  return node;
}

function text(value, unit) {
  const size = Math.abs(value);
  const digits = size === 0 || size >= 100 ? 0 : Math.max(0, 2 - Math.floor(Math.log10(size)));
  return `${value.toFixed(Math.min(digits, size < 0.01 && size > 0 ? 6 : 3))} ${unit}`.trim();
}

// A slider whose input runs from 0 to 1, so that its scale may be logarithmic. One whose ends are the same
// number cannot be moved.
function slider(low, high, logarithmic) {
  const input = make("input", {type: "range", min: 0, max: 1, step: 0.002});
  const ratio = Math.log(high / low);
  input.disabled = low === high;
  return {
    input,
    get: () => {
      const x = +input.value;
      if (x === 0 || x === 1) return x ? high : low;
      return logarithmic ? low * Math.exp(x * ratio) : low + x * (high - low);
    },
    set: (value) => {
      if (low === high) input.value = 0.5;
      else input.value = logarithmic ? Math.log(Math.max(value, low) / low) / ratio : (value - low) / (high - low);
    },
  };
}

Object.assign(wbc, {make, text, slider});
})();
