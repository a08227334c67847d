layout(std430, binding = 0) readonly buffer Views { View views[]; };
