// Draws points and axes on a canvas, fast enough for tens of thousands of points.
import type { Theme } from "../../viewer/colours";
import type { PointAxis } from "./point_axis";
import type { PointColours } from "./point_colours";

export interface Area {
  readonly left: number;
  readonly top: number;
  readonly width: number;
  readonly height: number;
}

export interface Picture {
  readonly x: PointAxis;
  readonly y: PointAxis;
  readonly titles: { readonly x: string; readonly y: string };
  readonly colours: PointColours;
  readonly marked: Uint8Array | null;
  readonly theme: Theme;
}

/** Of the points, within a canvas of this size. */
export const areaOf = (width: number, height: number): Area => ({
  left: 62,
  top: 30,
  width: Math.max(width - 62 - 14, 20),
  height: Math.max(height - 30 - 42, 20),
});

/** Positions of points (px), by row; NaN if there is none within the limits of the axis. */
export interface Points {
  readonly x: Float32Array;
  readonly y: Float32Array;
}

export function positions(x: PointAxis, y: PointAxis, { left, top, width, height }: Area): Points {
  const share = (axis: PointAxis, value: number) => {
    const at = (value - axis.low) / (axis.high - axis.low);
    return at >= 0 && at <= 1 ? at : NaN;
  };
  return {
    x: Float32Array.from(x.at, (value) => left + share(x, value) * width),
    y: Float32Array.from(y.at, (value) => top + (1 - share(y, value)) * height),
  };
}

function fitted(context: CanvasRenderingContext2D, text: string, width: number): string {
  if (context.measureText(text).width <= width) return text;
  let length = text.length;
  while (length > 1 && context.measureText(`${text.slice(0, length)}…`).width > width) length--;
  return `${text.slice(0, length)}…`;
}

function drawAxes(context: CanvasRenderingContext2D, { x, y, titles, theme }: Picture, area: Area) {
  const { left, top, width, height } = area;
  context.font = "11px system-ui, sans-serif";
  context.lineWidth = 1;
  const [across, up] = [x.ticks(width / 80), y.ticks(height / 50)];
  context.strokeStyle = theme.grid;
  context.beginPath();
  for (const value of across.at) {
    const at = Math.round(left + ((value - x.low) / (x.high - x.low)) * width) + 0.5;
    context.moveTo(at, top);
    context.lineTo(at, top + height);
  }
  for (const value of up.at) {
    const at = Math.round(top + height - ((value - y.low) / (y.high - y.low)) * height) + 0.5;
    context.moveTo(left, at);
    context.lineTo(left + width, at);
  }
  context.stroke();
  context.fillStyle = theme.ink;
  context.textBaseline = "top";
  context.textAlign = "center";
  const room = width / Math.max(across.at.length, 1) - 6;
  across.at.forEach((value, i) => {
    const label = fitted(context, across.labels[i], Math.max(room, 24));
    const half = context.measureText(label).width / 2; // the last label stays on the canvas
    const at = Math.min(left + ((value - x.low) / (x.high - x.low)) * width, left + width + 12 - half);
    context.fillText(label, at, top + height + 5);
  });
  context.textBaseline = "middle";
  context.textAlign = "right";
  up.at.forEach((value, i) => {
    const at = top + height - ((value - y.low) / (y.high - y.low)) * height;
    context.fillText(fitted(context, up.labels[i], left - 8), left - 6, at);
  });
  context.font = "600 12px system-ui, sans-serif";
  context.textBaseline = "bottom";
  context.fillText(fitted(context, titles.x, width), left + width, top + height + 40);
  context.textAlign = "left";
  context.fillText(fitted(context, titles.y, width + left - 8), 6, top - 12);
}

/** The points for which `holds`, in one path for each colour. */
function drawPoints(
  context: CanvasRenderingContext2D,
  at: Points,
  { colours }: Picture,
  radius: number,
  holds: (row: number) => boolean,
) {
  colours.palette.forEach((colour, kind) => {
    context.fillStyle = colour;
    context.beginPath();
    for (let row = 0; row < at.x.length; row++) {
      if (colours.of[row] !== kind || Number.isNaN(at.x[row] + at.y[row]) || !holds(row)) continue;
      if (radius < 2) context.rect(at.x[row] - radius, at.y[row] - radius, 2 * radius, 2 * radius);
      else {
        context.moveTo(at.x[row] + radius, at.y[row]);
        context.arc(at.x[row], at.y[row], radius, 0, 2 * Math.PI);
      }
    }
    context.fill();
  });
}

export const radiusFor = (points: number) => (points > 8000 ? 1.3 : points > 2000 ? 2 : 3.2);

/** `width`, `height`: of the canvas (px). Points that are not marked, if any are, fade. */
export function draw(context: CanvasRenderingContext2D, picture: Picture, at: Points, width: number, height: number) {
  const { marked } = picture;
  const radius = radiusFor(at.x.length);
  context.setTransform(devicePixelRatio, 0, 0, devicePixelRatio, 0, 0);
  context.clearRect(0, 0, width, height);
  drawAxes(context, picture, areaOf(width, height));
  if (marked) {
    context.globalAlpha = 0.14;
    drawPoints(context, at, picture, radius, (row) => marked[row] === 0);
  }
  context.globalAlpha = 0.85;
  drawPoints(context, at, picture, radius, (row) => !marked || marked[row] === 1);
  context.globalAlpha = 1;
}
