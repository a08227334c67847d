// How large the picture is drawn while it moves: smaller where the machine is slow, and in full when it rests.
const sizes = [1, 0.84, 0.71, 0.59, 0.5, 0.42, 0.35];
const slowMs = 32, fastMs = 17; // of a frame; guessed

export class Pace {
  private index = 0;
  private smoothedMs = 0;
  private sinceChange = 0;

  /** Of the width and height, while the picture moves. */
  get size(): number {
    return sizes[this.index]!;
  }
  /** After a frame of a movement that took so long. */
  note(ms: number): void {
    this.smoothedMs = this.smoothedMs === 0 ? ms : 0.7 * this.smoothedMs + 0.3 * Math.min(ms, 250);
    ++this.sinceChange;
    const patience = 4; // frames at one size
    if (this.sinceChange < patience) return;
    if (this.smoothedMs > slowMs && this.index + 1 < sizes.length) this.change(this.smoothedMs > 2 * slowMs ? 2 : 1);
    else if (this.smoothedMs < fastMs && this.index > 0 && this.sinceChange > 30) this.change(-1);
  }
  private change(by: number): void {
    this.index = Math.min(Math.max(this.index + by, 0), sizes.length - 1);
    this.sinceChange = 0;
    this.smoothedMs = 0;
  }
}
