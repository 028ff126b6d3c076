// The live figures of the site. The program computed their data when the site was built; live.py says how.

const COLOURS = ['#d55e00', '#777777', '#0072b2', '#009e73', '#cc79a7'];

/** Widths of the arrows, px: equal velocities stay visible. */
const WIDTHS = [10, 7, 5, 3, 2];

/** Half of the width of the shown plane, rad/s. Longer arrows are cut off. */
const REACH = 2.5;

const element = (name, attributes, ...children) => {
  const node = document.createElementNS('http://www.w3.org/2000/svg', name);
  for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
  node.append(...children);
  return node;
};

const line = (x, y, attributes) => element('line', { x1: 0, y1: 0, x2: x, y2: -y, 'vector-effect': 'non-scaling-stroke', ...attributes });

/** Writes a number with three digits. */
const digits = (value) => (Math.abs(value) < 5e-4 ? '0' : Number(value.toPrecision(3)).toString());

/** Two tasks that come into conflict: a slider for the angle, the joint velocities as arrows, and the numbers. */
function conflict(place, { angles, curves }) {
  place.innerHTML = `
    <label>Angle between the directions of the two tasks: <output></output>
      <input type="range" min="0" max="${angles.length - 1}" value="${angles.indexOf(3)}"></label>
    <div class="parts"><svg viewBox="${-REACH} -0.3 ${2 * REACH} ${REACH + 0.3}" role="img"
      aria-label="Joint velocities of the methods as arrows in the plane of two joints"></svg>
    <div class="numbers"><table><thead><tr><th>method</th><th>‖q̇‖, rad/s</th><th>residual of task 1</th>
      <th>residual of task 2</th></tr></thead><tbody></tbody></table></div></div>
    <p>Dashed: the directions of the tasks. Arrows: the joint velocity of each method, rad/s, cut off at ${REACH}.</p>`;
  const [slider, output, picture, body] = ['input', 'output', 'svg', 'tbody'].map((part) => place.querySelector(part));
  const draw = () => {
    const index = Number(slider.value);
    const angle = (angles[index] * Math.PI) / 180;
    const [a, b] = [[1, 0], [Math.cos(angle), Math.sin(angle)]];
    output.textContent = `${angles[index]}°`;
    const axes = [a, b.map((value) => -value)].map(([x, y]) => line(REACH * x, REACH * y, { stroke: 'currentColor', 'stroke-dasharray': '4 4' }));
    const arrows = curves.map(({ velocity }, k) => {
      const [x, y] = velocity[index];
      const cut = Math.min(1, (0.98 * REACH) / Math.hypot(x, y));
      const style = { stroke: COLOURS[k], 'stroke-width': WIDTHS[k] };
      const tip = element('circle', { cx: cut * x, cy: -cut * y, r: 0.07, fill: COLOURS[k] });
      return element('g', {}, line(cut * x, cut * y, style), tip);
    });
    picture.replaceChildren(...axes, ...arrows);
    body.innerHTML = curves.map(({ label, velocity }, k) => {
      const [x, y] = velocity[index];
      const residuals = [a[0] * x + a[1] * y - 1, b[0] * x + b[1] * y + 1];
      const cells = [Math.hypot(x, y), ...residuals.map(Math.abs)].map((value) => `<td>${digits(value)}</td>`).join('');
      return `<tr><td><span style="color:${COLOURS[k]}" aria-hidden="true">●</span> ${label}</td>${cells}</tr>`;
    }).join('');
  };
  slider.addEventListener('input', draw);
  draw();
}

for (const place of document.querySelectorAll('.live-figure')) {
  const data = globalThis.revprioFigures[place.dataset.figure];
  if (place.dataset.figure === 'conflict') conflict(place, data);
}
