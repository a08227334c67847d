// The files of a page's data. Each is a script that calls ulfData() with a JSON object and bytes in base64, because a
// page that is opened from a folder may run scripts of that folder but neither fetch() its files nor read pixels of its
// pictures.

type Place = ["f32" | "u16" | "u32", number, number];

export interface SceneHeader {
  kind: "scene";
  title: string;
  views: number;
  picture: [number, number];
  /** Small pictures have this share of the fine ones' width and height. */
  small: number;
  radius: number;
  up: [number, number, number];
  eye: [number, number, number];
  /** Width, height and focal length of a photograph, in its pixels. */
  lens: [number, number, number];
  /** Mean angle between neighbouring viewpoints; 0 where they span no surface. */
  spacing: number;
  lumigraphViews: number;
  lumigraphResolution: number;
  feather: number;
  /** Whether some of the pictures have parts without light. */
  masks: boolean;
  files: [string, number][];
  arrays: Record<string, Place>;
}
export interface GeometryHeader {
  kind: "geometry";
  /** Whether a finer one comes later. */
  coarse: boolean;
  geometry: { low: [number, number, number]; step: [number, number, number] } | null;
  arrays: Record<string, Place>;
}
export interface PicturesHeader {
  kind: "small" | "fine";
  /** View, first byte, bytes. */
  views: [number, number, number][];
}
export type Header = SceneHeader | GeometryHeader | PicturesHeader;
export type Receive = (header: Header, bytes: Uint8Array<ArrayBuffer>) => void;

function bytesOf(base64: string): Uint8Array<ArrayBuffer> {
  const text = atob(base64);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
  return bytes;
}

/** The numbers of a file, by name. */
export class Arrays {
  constructor(private readonly places: Record<string, Place>, private readonly bytes: Uint8Array<ArrayBuffer>) {}
  has(name: string): boolean {
    return name in this.places;
  }
  private place(name: string): Place {
    const place = this.places[name];
    if (!place) throw new Error(`the data have no ${name}`);
    return place;
  }
  f32(name: string): Float32Array {
    const [, at, count] = this.place(name);
    return new Float32Array(this.bytes.buffer, at, count);
  }
  integers(name: string): Uint16Array<ArrayBuffer> | Uint32Array<ArrayBuffer> {
    const [type, at, count] = this.place(name);
    return type === "u16" ? new Uint16Array(this.bytes.buffer, at, count) : new Uint32Array(this.bytes.buffer, at, count);
  }
}

/** From here on scripts hand their data to `receive`. Before the page's own script nothing may. */
export function receiveData(receive: Receive): void {
  (window as unknown as { ulfData: (header: Header, base64: string) => void }).ulfData = (header, base64) =>
    receive(header, bytesOf(base64));
}

/** Runs a script of the page's folder; tries again a few times, since phones lose connections. */
export async function load(file: string): Promise<void> {
  const tries = 4;
  for (let attempt = 1; ; ++attempt) {
    try {
      await new Promise<void>((resolve, reject) => {
        const script = document.createElement("script");
        script.src = file;
        script.onload = () => {
          script.remove();
          resolve();
        };
        script.onerror = () => {
          script.remove();
          reject(new Error(`${file} could not be loaded`));
        };
        document.head.append(script);
      });
      return;
    } catch (error) {
      if (attempt === tries) throw error;
      await new Promise((resolve) => setTimeout(resolve, 500 * 2 ** attempt));
    }
  }
}
