"use strict";
// Pictures are drawn from the tables beside them: what a point shows is what a cell says.
(() => {
  const SVG = "http://www.w3.org/2000/svg";
  const DASHES = ["", "7 3", "2 3", "9 3 2 3", "14 4"];
  const SHAPES = [
    "M-4 0a4 4 0 1 0 8 0a4 4 0 1 0 -8 0z", "M-3.6 -3.6h7.2v7.2h-7.2z", "M0 -4.6L4.3 3.4H-4.3z",
    "M0 -5L5 0L0 5L-5 0z", "M0 4.6L4.3 -3.4H-4.3z", "M-4 -4L4 4M-4 4L4 -4", "M-5 0H5M0 -5V5",
    "M-4 0a4 4 0 1 0 8 0a4 4 0 1 0 -8 0z"];
  const make = (name, attributes, parent, text) => {
    const node = name === "svg" || parent instanceof SVGElement
      ? document.createElementNS(SVG, name) : document.createElement(name);
    for (const key in attributes) node.setAttribute(key, attributes[key]);
    if (text !== undefined) node.textContent = text;
    if (parent) parent.append(node);
    return node;
  };
  // one look for a method in all pictures; several lines of a method in one picture differ in their dashes
  const LOOKS = JSON.parse(document.body.dataset.looks || "{}");
  const looks = (names) => {
    const seen = {};
    return names.map((name, n) => {
      const k = LOOKS[name] ?? n, again = seen[k] = (seen[k] ?? -1) + 1;
      return { color: k % 7, dash: DASHES[(k + again) % 5], shape: (k + Math.floor(again / 5)) % 8 };
    });
  };
  const mark = (parent, { color, shape }, extra) => make("path",
    { d: SHAPES[shape], class: `mark c${color}${shape === 7 ? " hollow" : ""}`, ...extra }, parent);
  // a text is moved into its room, and set narrower where it is longer than that
  const fit = (text, low, high) => {
    const box = text.getBBox(), room = high - low;
    if (box.width > room) {
      text.setAttribute("textLength", room);
      text.setAttribute("lengthAdjust", "spacingAndGlyphs");
    }
    const begin = Math.min(Math.max(box.x, low), high - Math.min(box.width, room));
    if (box.width > room || Math.abs(begin - box.x) > 0.1) {
      text.setAttribute("text-anchor", "start");
      text.setAttribute("x", begin);
    }
  };
  const longest = (axis) => 6.8 * Math.max(0, ...axis.ticks.map((t) => axis.label(t).length));

  // axes: a range becomes ticks, a value a place
  const nice = (rough, steps = [1, 2, 5, 10]) => {
    const power = 10 ** Math.floor(Math.log10(rough));
    return steps.map((m) => m * power).find((step) => step >= rough);
  };
  const axis = (values, linear, pixels) => {
    const to = linear ? (x) => x : Math.log10;
    let low = Math.min(...values.map(to)), high = Math.max(...values.map(to));
    const least = linear ? Math.max(1e-12, Math.abs(high) * 1e-3) : 0.5;
    const margin = Math.max(0.05 * (high - low), (least - (high - low)) / 2, 0);
    low -= margin; high += margin;
    const most = Math.max(2, Math.floor(pixels / 56)), ticks = [];
    if (linear) {
      const step = nice((high - low) / most);
      for (let k = Math.ceil(low / step); k * step <= high; k++) ticks.push(k * step);
    } else {
      const step = Math.max(1, Math.ceil((high - low) / most));
      for (let k = Math.ceil(low); k <= high; k++) if (k % step === 0) ticks.push(k);
      if (ticks.length < 2) {
        ticks.length = 0;
        for (let k = Math.floor(low); k <= high; k++)
          for (const m of [1, 2, 5]) {
            const x = k + Math.log10(m);
            if (x >= low && x <= high) ticks.push(x);
          }
      }
    }
    const label = (x) => {
      if (linear) return String(+x.toPrecision(6));
      const k = Math.floor(x + 1e-9), m = Math.round(10 ** (x - k));
      return k >= -2 && k <= 3 ? String(+(10 ** x).toPrecision(3)) : `${m}e${k}`;
    };
    return { ticks, label, at: (x) => (to(x) - low) / (high - low), part: (x) => (x - low) / (high - low) };
  };

  const read = (table) => {
    const heads = [...table.tHead.rows[0].cells].map((cell) => ({
      key: cell.dataset.key, title: cell.textContent.trim(), linear: cell.dataset.scale === "linear" }));
    const rows = [...table.tBodies[0].rows].map((row) => {
      const cells = [...row.cells].map((cell) => cell.textContent.trim());
      return Object.fromEntries(heads.map((head, i) => [head.key, cells[i]]));
    });
    return { heads, rows };
  };

  class Plot {
    constructor(figure) {
      this.figure = figure;
      const { heads, rows } = read(document.getElementById(figure.dataset.table));
      this.heads = heads; this.rows = rows;
      this.names = [...new Set(rows.map((row) => row[figure.dataset.series]))];
      this.looks = looks(this.names);
      this.hidden = new Set();
      const top = make("div", { class: "controls" }, figure);
      this.x = this.choice(top, "across", figure.dataset.x.split(" "));
      this.y = this.choice(top, "up", figure.dataset.y.split(" "));
      this.canvas = make("div", {}, figure);
      this.status = make("p", { class: "status", role: "status" }, figure);
      this.legend();
      figure.append(...figure.querySelectorAll("figcaption"));
      new ResizeObserver(() => {
        if (figure.clientWidth && figure.clientWidth !== this.width) this.draw();
      }).observe(figure);
    }
    choice(parent, word, keys) {
      const known = keys.filter((key) => this.rows.some((row) => Number(row[key]) > 0 ||
        (this.head(key)?.linear && row[key] !== "" && !isNaN(row[key]))));
      const label = make("label", {}, parent, word + " ");
      const select = make("select", {}, label);
      for (const key of known) make("option", { value: key }, select, this.head(key).title);
      if (known.length < 2) label.hidden = true;
      select.addEventListener("change", () => this.draw());
      return select;
    }
    head(key) { return this.heads.find((head) => head.key === key); }
    legend() {
      const box = make("div", { class: "legend", role: "group", "aria-label": "methods shown" }, this.figure);
      const buttons = [];
      const press = (name, button, on) => {
        on ? this.hidden.delete(name) : this.hidden.add(name);
        button.setAttribute("aria-pressed", String(on));
      };
      // with many lines one wants to begin with none of them
      if (this.names.length > 8) {
        const all = make("button", { type: "button", class: "all" }, box, "hide all");
        all.addEventListener("click", () => {
          const on = all.textContent === "show all";
          all.textContent = on ? "hide all" : "show all";
          buttons.forEach(([name, button]) => press(name, button, on));
          this.draw();
        });
      }
      this.names.forEach((name, k) => {
        const button = make("button", { type: "button", "aria-pressed": "true" }, box);
        buttons.push([name, button]);
        const svg = make("svg", { width: 34, height: 12, viewBox: "-17 -6 34 12", "aria-hidden": "true" }, button);
        make("path", { d: "M-17 0H17", class: `line c${this.looks[k].color}`, "stroke-dasharray": this.looks[k].dash }, svg);
        mark(svg, this.looks[k], {});
        make("span", {}, button, name);
        button.addEventListener("click", () => {
          press(name, button, this.hidden.has(name));
          this.draw();
        });
      });
    }
    usable(row, key) {
      const value = Number(row[key]);
      return row[key] !== "" && Number.isFinite(value) && (this.head(key).linear || value > 0);
    }
    draw() {
      const width = this.width = this.figure.clientWidth, { dataset } = this.figure;
      const kx = this.x.value, ky = this.y.value, finished = (row) => !("outcome" in row) || row.outcome === "completed";
      this.canvas.replaceChildren();
      this.points = [];
      const svg = this.svg = make("svg", { class: "chart", tabindex: "0", role: "application",
        "aria-label": `${dataset.label}; arrow keys go from point to point` });
      this.canvas.append(svg);
      const drawn = kx && ky ? this.rows.filter((row) => finished(row) && this.usable(row, kx) && this.usable(row, ky)) : [];
      const visible = drawn.filter((row) => !this.hidden.has(row[dataset.series]));
      const missing = this.rows.length - drawn.length;
      this.say(null, missing ? `${missing} of ${this.rows.length} rows of the table have no place in this picture: ` +
        "they are not completed, or a number is missing or not positive." : "");
      if (!visible.length) {
        this.size(width, 280);
        make("text", { x: width / 2, y: 140, "text-anchor": "middle" }, svg, "nothing to draw");
        return;
      }
      this.paint(visible, kx, ky, width);
      this.ring = make("circle", { class: "ring", r: 8, visibility: "hidden" }, svg);
      svg.addEventListener("pointermove", (event) => this.near(event));
      svg.addEventListener("pointerdown", (event) => this.near(event));
      svg.addEventListener("focus", () => { if (!this.chosen) this.choose(this.points[0]); });
      svg.addEventListener("keydown", (event) => this.key(event));
    }
    size(width, height) {
      for (const [key, value] of Object.entries({ width, height, viewBox: `0 0 ${width} ${height}` }))
        this.svg.setAttribute(key, value);
    }
    // grid, ticks and frame of a rectangle
    grid({ left, top, wide, high }, ax, ay) {
      let end = -Infinity;
      for (const t of ax.ticks) {
        const u = left + ax.part(t) * wide;
        make("path", { class: "grid", d: `M${u} ${top}v${high}` }, this.svg);
        const text = make("text", { x: u, y: top + high + 16, "text-anchor": "middle" }, this.svg, ax.label(t));
        fit(text, 2, this.width - 2);
        const { x, width } = text.getBBox();
        if (x < end + 4) text.remove(); else end = x + width;
      }
      for (const t of ay.ticks) {
        const v = top + high - ay.part(t) * high;
        make("path", { class: "grid", d: `M${left} ${v}h${wide}` }, this.svg);
        make("text", { x: left - 6, y: v + 4, "text-anchor": "end" }, this.svg, ay.label(t));
      }
      make("rect", { class: "frame", x: left, y: top, width: wide, height: high }, this.svg);
    }
    // rows of one line as points of a rectangle
    placed(rows, name, k, kx, ky, { left, top, wide, high }, ax, ay) {
      return rows.filter((row) => row[this.figure.dataset.series] === name).map((row) => ({
        row, k, u: left + ax.at(Number(row[kx])) * wide, v: top + high - ay.at(Number(row[ky])) * high }));
    }
    paint(rows, kx, ky, width) {
      const height = Math.round(Math.min(460, Math.max(280, width * 0.62))), svg = this.svg;
      const ay = axis(rows.map((row) => Number(row[ky])), this.head(ky).linear, (height - 72) * 1.5);
      const left = Math.max(62, 10 + longest(ay));
      const box = { left, top: 26, wide: width - left - 12, high: height - 72 };
      // what failed has a step size and no error; up to a limit the tableau predicts stability
      const failed = kx !== "h" && kx !== "steps" ? [] : this.rows.filter((row) => "outcome" in row &&
        row.outcome !== "completed" && this.usable(row, kx) && !this.hidden.has(row[this.figure.dataset.series]));
      const limits = new Map(kx === "h" ? this.rows.filter((row) => Number(row.limit) > 0 &&
        !this.hidden.has(row[this.figure.dataset.series])).map((row) => [row[this.figure.dataset.series], Number(row.limit)]) : []);
      const ax = axis([...rows, ...failed].map((row) => Number(row[kx])).concat([...limits.values()]), this.head(kx).linear, box.wide);
      this.size(width, height);
      this.grid(box, ax, ay);
      fit(make("text", { x: box.left + box.wide / 2, y: height - 10, "text-anchor": "middle", class: "x-title" }, svg,
        this.head(kx).title), 4, width - 4);
      fit(make("text", { x: 8, y: 16, class: "y-title" }, svg, this.head(ky).title), 8, width - 4);
      const quick = this.figure.dataset.marks === "no";
      this.names.forEach((name, k) => {
        const mine = this.placed(rows, name, k, kx, ky, box, ax, ay);
        if (!mine.length) return;
        const group = make("g", { "data-series": name }, svg);
        const look = this.looks[k];
        make("path", { class: `line c${look.color}`, "stroke-dasharray": look.dash, fill: "none",
          d: "M" + mine.map((p) => `${p.u.toFixed(1)} ${p.v.toFixed(1)}`).join("L") }, group);
        const bar = (q) => (box.left + Math.min(1, Math.max(0, ax.at(Number(q)))) * box.wide).toFixed(1);
        const bars = kx !== "seconds" || this.figure.dataset.bars === "no" ? [] : mine.filter((p) => p.row.q25 > 0 && p.row.q75 > 0)
          .map((p) => `M${bar(p.row.q25)} ${p.v.toFixed(1)}H${bar(p.row.q75)}`);
        if (bars.length) make("path", { class: `spread c${look.color}`, d: bars.join("") }, group);
        mine.forEach((p, n) => {
          if (!quick || n === mine.length - 1) mark(group, look, { transform: `translate(${p.u.toFixed(1)} ${p.v.toFixed(1)})` });
        });
        this.points.push(...mine);
      });
      this.names.forEach((name, k) => {
        const color = this.looks[k].color, group = make("g", { "data-failed": name }, svg);
        if (limits.has(name)) make("path", { class: `line limit c${color}`, "stroke-dasharray": "1.5 4",
          d: `M${(box.left + ax.at(limits.get(name)) * box.wide).toFixed(1)} ${box.top}v${box.high}` }, group);
        failed.filter((row) => row[this.figure.dataset.series] === name).forEach((row) => {
          const p = { row, k, u: box.left + ax.at(Number(row[kx])) * box.wide, v: box.top + 8 + 7 * (k % 8) };
          mark(group, { color, shape: 5 }, { transform: `translate(${p.u.toFixed(1)} ${p.v})` });
          this.points.push(p);
        });
      });
    }
    near(event) {
      const box = this.svg.getBoundingClientRect(), u = event.clientX - box.left, v = event.clientY - box.top;
      let best = null, least = 24 ** 2;
      for (const p of this.points) {
        const d = (p.u - u) ** 2 + (p.v - v) ** 2;
        if (d < least) { least = d; best = p; }
      }
      if (best) this.choose(best);
    }
    key(event) {
      const at = this.points.indexOf(this.chosen), mine = this.points.filter((p) => p.k === this.chosen?.k);
      const here = mine.indexOf(this.chosen), lines = [...new Set(this.points.map((p) => p.k))];
      const other = (step) => {
        const k = lines[(lines.indexOf(this.chosen.k) + step + lines.length) % lines.length];
        return this.points.filter((p) => p.k === k)[Math.min(here, this.points.filter((p) => p.k === k).length - 1)];
      };
      const next = at < 0 ? this.points[0] : {
        ArrowRight: () => mine[Math.min(here + 1, mine.length - 1)], ArrowLeft: () => mine[Math.max(here - 1, 0)],
        ArrowDown: () => other(1), ArrowUp: () => other(-1), Home: () => mine[0], End: () => mine[mine.length - 1] }[event.key]?.();
      if (next) { event.preventDefault(); this.choose(next); }
    }
    choose(point) {
      if (!point || this.chosen === point) return;
      this.ring.setAttribute("cx", point.u); this.ring.setAttribute("cy", point.v);
      this.ring.setAttribute("visibility", "visible");
      this.say(point);
    }
    say(point, note = "") {
      this.chosen = point;
      this.status.textContent = point
        ? this.heads.filter((head) => point.row[head.key] && point.row[head.key] !== "–")
            .map((head) => `${head.title}: ${point.row[head.key]}`).join("; ")
        : note || "Point at the picture, or go through it with the arrow keys, to see a point's numbers.";
    }
  }
  // paths in a plane: a panel for each line, one unit for both axes, points that are not joined; a run
  // that ended early does not set the range
  class Plane extends Plot {
    paint(rows, kx, ky, width) {
      const { series, plane } = this.figure.dataset, partial = new Set(JSON.parse(plane)), svg = this.svg;
      const names = this.names.filter((name) => rows.some((row) => row[series] === name));
      const across = Math.max(Math.min(names.length, 2), Math.min(names.length, Math.floor(width / 270)));
      const cell = Math.min(Math.floor(width / across), 420);
      const whole = rows.filter((row) => !partial.has(row[series]));
      const ranging = whole.length ? whole : rows;
      const left = Math.max(50, 26 + longest(this.equal(ranging, kx, ky, cell - 60)[1])), wide = cell - left - 10;
      const [ax, ay, high] = this.equal(ranging, kx, ky, wide);
      const pitch = high + 68;
      this.size(width, Math.ceil(names.length / across) * pitch + 4);
      names.forEach((name, n) => {
        const k = this.names.indexOf(name);
        const box = { left: (n % across) * cell + left, top: Math.floor(n / across) * pitch + 24, wide, high };
        this.grid(box, ax, ay);
        const { h } = rows.find((row) => row[series] === name);
        const room = [box.left - left + 4, box.left + wide + 6];
        fit(make("text", { x: box.left, y: box.top - 8 }, svg, h === undefined || cell < 200 ? name : `${name}, h = ${h}`), ...room);
        fit(make("text", { x: box.left + wide / 2, y: box.top + high + 32, "text-anchor": "middle", class: "x-title" }, svg,
          this.head(kx).title), ...room);
        fit(make("text", { transform: `translate(${box.left - left + 12} ${box.top + high / 2}) rotate(-90)`,
          "text-anchor": "middle", class: "y-title" }, svg, this.head(ky).title), -high / 2 - 20, high / 2 + 20);
        const group = make("g", { "data-series": name }, svg);
        const inside = (p) => p.u >= box.left && p.u <= box.left + wide && p.v >= box.top && p.v <= box.top + high;
        const mine = this.placed(rows, name, k, kx, ky, box, ax, ay).filter(inside);
        for (const p of mine) mark(group, this.looks[k], { transform: `translate(${p.u.toFixed(1)} ${p.v.toFixed(1)}) scale(.4)` });
        this.points.push(...mine);
      });
      const outside = rows.length - this.points.length;
      if (outside) this.say(null, `${outside} of ${rows.length} points lie outside of these ranges.`);
    }
    // two axes of one unit, and the height that fits
    equal(rows, kx, ky, wide) {
      const span = (key) => {
        const values = rows.map((row) => Number(row[key])), low = Math.min(...values), high = Math.max(...values);
        return { middle: (low + high) / 2, size: 1.08 * (high - low), far: Math.max(Math.abs(low), Math.abs(high)) };
      };
      const x = span(kx), y = span(ky), most = Math.max(x.size, y.size) || Math.max(x.far, y.far) || 1;
      const high = Math.round(wide * Math.min(1.4, Math.max(0.3, y.size / (x.size || most))));
      const unit = Math.max(x.size / wide, y.size / high) || most / wide;
      const line = (middle, pixels) => {
        const low = middle - unit * pixels / 2, ticks = [];
        const step = nice(unit * pixels / Math.max(3, Math.floor(pixels / 40)), [1, 2, 2.5, 5, 10]);
        for (let k = Math.ceil(low / step); k * step <= low + unit * pixels; k++) ticks.push(k * step);
        const part = (value) => (value - low) / (unit * pixels);
        return { ticks, label: (value) => String(+value.toPrecision(6)), at: part, part };
      };
      return [line(x.middle, wide), line(y.middle, high), high];
    }
  }
  document.querySelectorAll("figure[data-table]").forEach((figure) => figure.dataset.plane ? new Plane(figure) : new Plot(figure));

  // a menu closes behind the link that was followed: on one page it would stay in the way
  document.querySelectorAll("nav details a").forEach((link) => link.addEventListener("click", () => {
    link.closest("details").open = false;
  }));

  // tables that can be sorted and filtered
  document.querySelectorAll("table.sortable").forEach((table) => {
    const body = table.tBodies[0], heads = [...table.tHead.rows[0].cells];
    heads.forEach((head, i) => {
      const button = make("button", { type: "button" });
      button.append(...head.childNodes);
      head.append(button);
      button.addEventListener("click", () => {
        const down = head.getAttribute("aria-sort") === "ascending" ? -1 : 1;
        heads.forEach((other) => other.removeAttribute("aria-sort"));
        head.setAttribute("aria-sort", down > 0 ? "ascending" : "descending");
        const value = (row) => row.cells[i].textContent.trim();
        const rows = [...body.rows].sort((a, b) => {
          const x = value(a), y = value(b), numbers = x !== "" && y !== "" && !isNaN(x) && !isNaN(y);
          return down * (numbers ? x - y : x.localeCompare(y));
        });
        body.append(...rows);
      });
    });
    // of a table that is searched, only rows that hold every word are shown, and not more than these
    const searched = table.classList.contains("found"), most = searched ? 200 : Infinity;
    const label = make("label", {});
    label.textContent = searched ? "search " : "filter rows by ";
    const input = make("input", { type: "search", placeholder: "words" }, label);
    const line = make("div", { class: "controls" });
    const told = make("span", { role: "status" });
    line.append(label, told);
    table.closest(".scroll").before(line);
    const texts = new Map();
    const text = (row) => {
      if (!texts.has(row)) texts.set(row, [...row.cells].map((cell) => cell.textContent.toLowerCase()).join(" "));
      return texts.get(row);
    };
    const filter = () => {
      const words = input.value.toLowerCase().split(/\s+/).filter(Boolean);
      let found = 0;
      for (const row of body.rows) {
        const hit = (words.length > 0 || !searched) && words.every((word) => text(row).includes(word));
        row.hidden = !hit || found >= most;
        found += hit;
      }
      const first = found > most ? `, the first ${most} are shown` : "";
      if (searched) told.textContent = words.length ? `${found} ${found === 1 ? "row" : "rows"}${first}` : "";
    };
    input.addEventListener("input", filter);
    if (searched) {
      input.value = new URLSearchParams(location.search).get("words") ?? "";
      filter();
    }
  });

  // the field of every page: it opens the page of the search
  document.querySelectorAll(".search").forEach((field) => {
    field.hidden = false;
    const own = field.querySelector("input"), to = field.dataset.to;
    own.addEventListener("keydown", (event) => {
      if (event.key !== "Enter") return;
      const words = own.value;
      if (!to.startsWith("#")) {
        location.href = `${to}?words=${encodeURIComponent(words)}`;
        return;
      }
      const input = document.querySelector(`${to} .controls input`);
      input.value = words;
      input.dispatchEvent(new Event("input"));
      location.hash = to;
    });
  });
})();
