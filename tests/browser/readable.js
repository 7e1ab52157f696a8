// What of a page is too small or too pale to be read: see readable.py.
([leastSize, leastContrast]) => {
  const rgba = (text) => {
    const [r, g, b, a] = text.match(/[\d.]+/g).map(Number);
    const scale = text.startsWith("color(") ? 255 : 1;
    return [r * scale, g * scale, b * scale, a ?? 1];
  };
  const over = ([r, g, b, a], [R, G, B]) => [r, g, b].map((v, k) => v * a + [R, G, B][k] * (1 - a));
  const luminance = (colour) => {
    const [r, g, b] = colour.map((v) => v / 255).map((v) => v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4);
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const behind = (element) => {
    const layers = [];
    for (let at = element; at; at = at.parentElement) layers.push(rgba(getComputedStyle(at).backgroundColor));
    return layers.reverse().reduce((below, layer) => over(layer, below), [255, 255, 255]);
  };
  const found = new Set();
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walker.nextNode()) {
    const text = walker.currentNode.textContent.trim(), element = walker.currentNode.parentElement;
    if (!text || element.closest("style, script, title, button:disabled, [data-disabled], [aria-disabled=true]")) continue;
    if (!element.checkVisibility({ opacityProperty: true, visibilityProperty: true })) continue;
    const box = element.getBoundingClientRect();
    if (box.width < 2 || box.height < 2) continue;
    const style = getComputedStyle(element), back = behind(element);
    let [r, g, b, alpha] = rgba(style.color);
    for (let at = element; at; at = at.parentElement) alpha *= Number(getComputedStyle(at).opacity);
    const [light, dark] = [luminance(over([r, g, b, alpha], back)), luminance(back)].sort((x, y) => y - x);
    const contrast = (light + 0.05) / (dark + 0.05), size = parseFloat(style.fontSize);
    if (size < leastSize - 0.05) found.add(`${size.toFixed(1)} px: ${text.slice(0, 40)}`);
    if (contrast < leastContrast - 0.01) found.add(`contrast ${contrast.toFixed(2)}: ${text.slice(0, 40)}`);
  }
  return [...found];
}
