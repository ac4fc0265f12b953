#version 330
// From added light to what a screen shows: highlights eased, the background behind, sRGB.

in vec2 spot;

uniform sampler2D light;
uniform bool backdrop;
uniform vec4 background;  // sRGB and opacity, where there is no backdrop

out vec4 result;

vec3 linear(vec3 color) {
    return mix(color / 12.92, pow((color + 0.055) / 1.055, vec3(2.4)), step(0.04045, color));
}

vec3 shown(vec3 color) {
    return mix(color * 12.92, 1.055 * pow(color, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, color));
}

// Linear up to a knee, then ever slower towards 1, so that hue and contrast stay below it.
vec3 eased(vec3 color) {
    const float knee = 0.66;
    float peak = max(color.r, max(color.g, color.b));
    if (peak <= knee) return color;
    float soft = knee + (1.0 - knee) * (1.0 - exp(-(peak - knee) / (1.0 - knee)));
    return color * (soft / peak);
}

void main() {
    vec4 seen = max(texture(light, spot), 0.0);
    vec3 front = eased(seen.rgb);
    vec4 behind = background;
    if (backdrop) {
        vec3 low = vec3(0.898, 0.890, 0.876);
        vec3 high = vec3(0.742, 0.776, 0.812);
        behind = vec4(mix(low, high, smoothstep(0.25, 1.15, spot.y)), 1.0);
    }
    float alpha = seen.a + (1.0 - seen.a) * behind.a;
    vec3 color = front + linear(behind.rgb) * behind.a * (1.0 - seen.a);
    color = shown(alpha > 0.0 ? clamp(color / alpha, 0.0, 1.0) : vec3(0.0));
    // Half a step of noise in a fixed pattern keeps slow gradients from banding.
    float noise = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));
    result = vec4(color + (noise - 0.5) * 0.9 / 255.0, alpha);
}
