// Fingers, mouse and keys as movements.
export interface Movements {
  turn(right: number, up: number): void;
  zoomBy(factor: number): void;
  focusAt(x: number, y: number): void;
  key(event: KeyboardEvent): boolean;
  rest(): void;
}

const turnPerPx = 0.005, zoomPerPx = 0.0015; // guessed
const tapPx = 6, tapMs = 350;

export function listen(canvas: HTMLElement, movements: Movements): void {
  const fingers = new Map<number, { x: number; y: number }>();
  let down = { x: 0, y: 0, time: 0, travelled: 0 };
  let apart = 0;

  const spread = (): number => {
    const [a, b] = [...fingers.values()];
    return a && b ? Math.hypot(a.x - b.x, a.y - b.y) : 0;
  };
  canvas.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    canvas.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    down = { x: event.clientX, y: event.clientY, time: event.timeStamp, travelled: fingers.size > 1 ? tapPx : 0 };
    apart = spread();
    canvas.classList.add("held");
  });
  canvas.addEventListener("pointermove", (event) => {
    const finger = fingers.get(event.pointerId);
    if (!finger) return;
    const dx = event.clientX - finger.x, dy = event.clientY - finger.y;
    finger.x = event.clientX;
    finger.y = event.clientY;
    down.travelled = Math.max(down.travelled, Math.hypot(event.clientX - down.x, event.clientY - down.y));
    if (fingers.size === 1) {
      if (down.travelled >= tapPx) movements.turn(-dx * turnPerPx, dy * turnPerPx);
    } else {
      const now = spread();
      if (apart > 0 && now > 0) movements.zoomBy(now / apart);
      apart = now;
    }
  });
  const lift = (event: PointerEvent): void => {
    if (!fingers.delete(event.pointerId)) return;
    apart = spread();
    if (fingers.size > 0) return;
    canvas.classList.remove("held");
    movements.rest();
    if (event.type === "pointerup" && down.travelled < tapPx && event.timeStamp - down.time < tapMs)
      movements.focusAt(event.clientX, event.clientY);
  };
  canvas.addEventListener("pointerup", lift);
  canvas.addEventListener("pointercancel", lift);
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    const lines = event.deltaMode === 1 ? 16 : event.deltaMode === 2 ? 400 : 1;
    movements.zoomBy(Math.exp(-event.deltaY * lines * zoomPerPx));
  }, { passive: false });
  window.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.target instanceof HTMLInputElement && event.key.startsWith("Arrow")) return;
    if (movements.key(event)) event.preventDefault();
  });
}
