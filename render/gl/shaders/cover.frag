flat in float confidence;
out vec4 color;  // as the normalising pass reads it: the confidence of weights that sum to 1

void main() { color = vec4(confidence, 1.0, 0.0, 0.0); }
