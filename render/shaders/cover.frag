flat in float confidence;
out vec4 color;

void main() { color = vec4(confidence); }
