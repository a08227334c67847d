// WebGL 2 in few words.
export class Program {
  private readonly program: WebGLProgram;
  private readonly places = new Map<string, WebGLUniformLocation | null>();
  private isChecked = false; // asking for the outcome waits for the compiler: not before it is needed

  constructor(private readonly gl: WebGL2RenderingContext, vertex: string, fragment: string) {
    this.program = gl.createProgram();
    for (const [type, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]] as const) {
      const shader = gl.createShader(type);
      if (!shader) throw new Error("the graphics were lost");
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      gl.attachShader(this.program, shader);
      gl.deleteShader(shader); // when the program goes
    }
    gl.linkProgram(this.program);
  }

  private check(): void {
    const { gl, program } = this;
    this.isChecked = true;
    if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost()) {
      const logs = (gl.getAttachedShaders(program) ?? []).map((shader) => gl.getShaderInfoLog(shader));
      throw new Error(`shaders: ${[...logs, gl.getProgramInfoLog(program)].join(" ")}`);
    }
    const views = gl.getUniformBlockIndex(program, "Views");
    if (views !== gl.INVALID_INDEX) gl.uniformBlockBinding(program, views, 0);
  }

  use(): this {
    if (!this.isChecked) this.check();
    this.gl.useProgram(this.program);
    return this;
  }
  private at(name: string): WebGLUniformLocation | null {
    if (!this.places.has(name)) this.places.set(name, this.gl.getUniformLocation(this.program, name));
    return this.places.get(name) ?? null;
  }
  integer(name: string, value: number): this {
    this.gl.uniform1i(this.at(name), value);
    return this;
  }
  vectors(name: string, values: Float32Array): this {
    this.gl.uniform4fv(this.at(name), values);
    return this;
  }
  numbers(name: string, ...values: number[]): this {
    const place = this.at(name);
    if (values.length === 1) this.gl.uniform1f(place, values[0]!);
    else if (values.length === 3) this.gl.uniform3fv(place, values);
    else this.gl.uniform4fv(place, values);
    return this;
  }
}

/** A texture of one level. */
export function texture(gl: WebGL2RenderingContext, target: GLenum, filter: GLenum): WebGLTexture {
  const made = gl.createTexture();
  gl.bindTexture(target, made);
  gl.texParameteri(target, gl.TEXTURE_MIN_FILTER, filter);
  gl.texParameteri(target, gl.TEXTURE_MAG_FILTER, filter);
  gl.texParameteri(target, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
  gl.texParameteri(target, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
  return made;
}

/** A picture that is drawn into, and read afterwards. */
export class Target {
  readonly texture: WebGLTexture;
  private readonly frame: WebGLFramebuffer;
  width = 0;
  height = 0;

  constructor(private readonly gl: WebGL2RenderingContext, private readonly format: GLenum, filter: GLenum) {
    this.texture = texture(gl, gl.TEXTURE_2D, filter);
    this.frame = gl.createFramebuffer();
  }

  get isDepth(): boolean {
    return this.format === this.gl.DEPTH_COMPONENT24;
  }

  resize(width: number, height: number): void {
    if (width === this.width && height === this.height) return;
    const gl = this.gl;
    this.width = width;
    this.height = height;
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    const [layout, type] = this.isDepth ? [gl.DEPTH_COMPONENT, gl.UNSIGNED_INT]
      : this.format === gl.R16F ? [gl.RED, gl.HALF_FLOAT]
      : this.format === gl.RGBA8 ? [gl.RGBA, gl.UNSIGNED_BYTE] : [gl.RED, gl.UNSIGNED_BYTE];
    gl.texImage2D(gl.TEXTURE_2D, 0, this.format, width, height, 0, layout, type, null);
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.frame);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, this.isDepth ? gl.DEPTH_ATTACHMENT : gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D,
      this.texture, 0);
    if (this.isDepth) {
      gl.drawBuffers([gl.NONE]);
      gl.readBuffer(gl.NONE);
    }
  }

  bind(): void {
    this.gl.bindFramebuffer(this.gl.FRAMEBUFFER, this.frame);
    this.gl.viewport(0, 0, this.width, this.height);
  }

  /** Onto the canvas, pixel by pixel. */
  copyToScreen(): void {
    const gl = this.gl, { width, height } = this;
    gl.bindFramebuffer(gl.READ_FRAMEBUFFER, this.frame);
    gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, null);
    gl.blitFramebuffer(0, 0, width, height, 0, 0, width, height, gl.COLOR_BUFFER_BIT, gl.NEAREST);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.viewport(0, 0, width, height);
  }
}
