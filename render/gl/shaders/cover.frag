flat in float confidence;
out vec4 color;  // for the normalising pass: confidence times weight, and the weight, which is 1

void main() { color = vec4(confidence, 1.0, 0.0, 0.0); }
