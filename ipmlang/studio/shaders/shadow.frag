#version 330
// Depth alone; what is partly transparent stops that share of the lights.

in vec4 tone;
in vec2 place;
flat in float chance;

uniform bool textured;
uniform sampler2D image;
uniform float turn;

void main() {
    float alpha = tone.a;
    if (textured) alpha *= texture(image, place).a;
    if (alpha <= fract(turn + chance)) discard;
}
