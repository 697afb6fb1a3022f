// Looks at a page from inside and writes what it finds into it, as JSON.
addEventListener("load", () => {
  const inside = (part, whole) =>
    part.left >= whole.left - 0.5 && part.right <= whole.right + 0.5 &&
    part.top >= whole.top - 0.5 && part.bottom <= whole.bottom + 0.5;
  const grown = (box, by) => ({
    left: box.left - by, right: box.right + by, top: box.top - by, bottom: box.bottom + by,
  });
  const overlap = (a, b) =>
    Math.min(a.right, b.right) - Math.max(a.left, b.left) > 1 &&
    Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 3;
  // In pixels of the chart's own size.
  const unit = (shape) => {
    const svg = shape.closest("svg");
    return svg.viewBox.baseVal.width / Number(svg.getAttribute("width"));
  };
  const points = (shape) =>
    shape.getAttribute("points").trim().split(/\s+/)
      .map((pair) => pair.split(",").map((v) => Number(v) / unit(shape)));
  const luminance = (color) => {
    const [r, g, b] = color.match(/[\d.]+/g).map(Number).map((v) => {
      const s = v / 255;
      return s <= 0.03928 ? s / 12.92 : ((s + 0.055) / 1.055) ** 2.4;
    });
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const contrast = (a, b) => {
    const [low, high] = [luminance(a), luminance(b)].sort((x, y) => x - y);
    return (high + 0.05) / (low + 0.05);
  };
  const paper = getComputedStyle(document.body).backgroundColor;
  const charts = [...document.querySelectorAll("figure")].map((figure) => {
    const svg = figure.querySelector("svg");
    const whole = svg.getBoundingClientRect();
    const view = { width: Number(svg.getAttribute("width")), height: Number(svg.getAttribute("height")) };
    const texts = [...svg.querySelectorAll("text")];
    const boxes = texts.map((text) => text.getBoundingClientRect());
    const words = texts.map((text) => text.textContent.trim());
    const lines = [...svg.querySelectorAll("polyline")].map((line) => ({
      color: line.getAttribute("stroke"),
      points: points(line),
    }));
    const circles = [...svg.querySelectorAll("circle")].map((circle) => ({
      color: circle.getAttribute("fill"),
      at: ["cx", "cy"].map((name) => Number(circle.getAttribute(name)) / unit(circle)),
    }));
    const corners = [...svg.querySelectorAll("polygon")].flatMap(points);
    const places = lines.flatMap((line) => line.points)
      .concat(circles.map((circle) => circle.at), corners);
    const clashes = boxes.flatMap((a, i) =>
      boxes.slice(i + 1).flatMap((b, j) =>
        overlap(a, b) ? [`${words[i]} | ${words[i + 1 + j]}`] : []));
    return {
      id: figure.id,
      words,
      // A frame is the only closed line of five points in ink.
      panels: lines.filter((l) => l.color === "#1E1E1E" && l.points.length === 5).length,
      lines,
      circles,
      lost: places.filter(([x, y]) =>
        !(x >= -1 && y >= -1 && x <= view.width + 1 && y <= view.height + 1)).length,
      outside: words.filter((_, i) => !inside(boxes[i], whole)),
      clashes,
      strays: [...svg.querySelectorAll("path")].map((path) => path.getBoundingClientRect())
        .filter((box) => !inside(grown(box, -3), whole)).length,
      paths: svg.querySelectorAll("path").length,
      fonts: Math.min(...texts.map((text) => parseFloat(getComputedStyle(text).fontSize) / unit(text)
        * (whole.width / view.width))),
      overflows: whole.right > innerWidth,
      contrast: Math.min(...texts.map((text) => contrast(getComputedStyle(text).fill, paper))),
    };
  });
  const found = document.createElement("pre");
  found.id = "found";
  found.textContent = JSON.stringify({
    title: document.title,
    text: document.body.innerText,
    status: document.querySelector(".status").className,
    charts,
    missed: [...document.querySelectorAll("tr.missed")].length,
    outcomes: Math.max(0, document.querySelectorAll("#expectations tr").length - 1),
    wider: document.documentElement.scrollWidth - innerWidth,
    contrast: Math.min(...[...document.querySelectorAll("h1,h2,p,td,th,dt,dd,figcaption")].map(
      (element) => contrast(getComputedStyle(element).color, paper))),
    requests: performance.getEntriesByType("resource").map((entry) => entry.name),
  });
  document.body.append(found);
});
