// One Adam step on one parameter (../adam.h), left as it is where the gradient is 0. Includers declare what
// they are told: rate after bias correction, gradient_scale, beta1, beta2, epsilon.
void adam(float gradient, inout float parameter, inout float mean, inout float variance) {
  if (gradient == 0) return;
  const float g = gradient * gradient_scale;
  mean = beta1 * mean + (1 - beta1) * g;
  variance = beta2 * variance + (1 - beta2) * g * g;
  parameter -= rate * mean / (sqrt(variance) + epsilon);
}
