out vec4 depth;

void main() { depth = vec4(1.0 / gl_FragCoord.w); }
