// How large the picture is drawn while it moves: smaller where the machine is slow, and in full when it rests.
const sizes = [1, 0.84, 0.71, 0.59, 0.5, 0.42, 0.35];
export const simpleSize = 0.5; // guessed
const slowMs = 34.5, fastMs = 17.5; // of a frame: thirty a second, and sixty

export class Pace {
  private index = 0;
  private smoothedMs = 0;
  private frames = 0; // at this size

  /** Of the width and height, while the picture moves. */
  get size(): number {
    return sizes[this.index]!;
  }
  /** Whether so small a picture gets coarse geometry and few views, too. */
  get simple(): boolean {
    return this.size <= simpleSize;
  }
  /** After a frame of a movement, which came so long after the one before. */
  note(ms: number): void {
    this.smoothedMs = this.frames === 0 ? ms : 0.6 * this.smoothedMs + 0.4 * ms;
    ++this.frames;
    const patience = 3, longPatience = 30;
    if (this.frames >= patience && this.smoothedMs > slowMs && this.index + 1 < sizes.length) {
      // The time is that of the pixels, about.
      const wanted = this.size * Math.sqrt(slowMs / this.smoothedMs);
      const fits = sizes.findIndex((size) => size <= wanted);
      this.change(fits < 0 ? sizes.length - 1 : Math.max(fits, this.index + 1));
    } else if (this.frames >= longPatience && this.smoothedMs < fastMs && this.index > 0) {
      this.change(this.index - 1);
    }
  }
  private change(index: number): void {
    this.index = index;
    this.frames = 0;
  }
}
