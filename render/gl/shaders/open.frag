// Draws nothing: the pixels are counted.
void main() {}
