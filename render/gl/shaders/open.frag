// Nothing is drawn: pixels are counted.
void main() {}
