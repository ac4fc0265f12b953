// The machine: which production is taken, and the loop over its instructions.

double total;    // of the shares so far
double drawn;    // the draw that chooses, less than 0 before it is known
uint taken;      // the alternative; NONE: none yet
uint generation; // of the shape

void share(uint alternative, double part) {
    if (!(part >= 0.0lf)) trouble(TROUBLE_SHARES);
    if (drawn < 0.0lf) {
        uvec2 words = mixed(own_key, CHOICE_SITE ^ SIGN_BIT);
        drawn = draw_of(words);
    }
    total += part;
    if (taken == NONE && drawn < total) taken = alternative;
}

// No production takes a shape: it stays as it is, with a key of its own, or is an error.
void none_taken(uint symbol) {
    if (steps == NONE && following < FINAL) {
        trouble(TROUBLE_NO_PRODUCTION);
        return;
    }
    uint parameters = code[symbols + symbol * ENTRY + ENTRY_ARITY];
    make(symbol, mixed(own_key, CHOICE_SITE), NONE, NONE, state_size, parameters);
}

// Where the code of a symbol's shape begins, and the generation of what it makes.
uint entered(uint symbol, uint its_generation) {
    uint entry = symbols + symbol * ENTRY;
    total = 0.0lf;
    drawn = -1.0lf;
    taken = NONE;
    if (its_generation < FINAL) {
        uint begin = code[entry + ENTRY_PRODUCTIONS];
        if (begin != NONE && (steps == NONE || its_generation < steps)) {
            following = its_generation + 1u;
            atomicMax(counts[COUNT_GENERATION], following);
            return begin;
        }
        begin = code[entry + ENTRY_INTERPRETATIONS];
        if (begin != NONE) {
            following = FINAL;
            return begin;
        }
    }
    key = own_key;
    return code[entry + ENTRY_MEANING];
}

uint spent;  // instructions so far

void run(uint at) {
    for (;;) {
        uint word = code[at], more = code[at + 1u], z = code[at + 2u], w = code[at + 3u];
        uint target = word >> 8 & 255u, a = word >> 16 & 255u, b = word >> 24;
        uint c = more & 255u, d = more >> 8 & 255u, n = more >> 24;
        at += 4u;
        spent++;
        switch (word & 255u) {
        case OP_END: return;
        case OP_LOAD: r[target] = data[z]; break;
        case OP_COPY: r[target] = r[a]; break;
        case OP_CALL: {
            double given[ARGUMENTS];
            given[0] = r[a];
            given[1] = r[b];
            given[2] = r[c];
            r[target] = function_of(z, given);
            break;
        }
        case OP_PICK: {
            uint place = uint(min(floor(r[a] * double(n)), double(n - 1u)));
            r[target] = r[code[z + place]];
            break;
        }
        case OP_KEY: key = z == NONE ? own_key : mixed(own_key, z); break;
        case OP_MIX: key = mixed(key, to_word(r[a])); break;
        case OP_UNIFORM: r[target] = draw_of(key); break;
        case OP_ROW:
            r[target] = data[z + (r[a] > 0.0lf ? uint(min(r[a], double(w - 1u))) : 0u)];
            break;
        case OP_MOVE: move_by(dvec3(r[a], r[b], r[c])); break;
        case OP_TURN: rotate_by(z, r[a]); break;
        case OP_ORIENT: orient_by(r[a], r[b], r[c], r[d]); break;
        case OP_SCALE:
            if (!(r[a] > 0.0lf)) trouble(TROUBLE_FACTOR);
            r[slot_scale] *= r[a];
            break;
        case OP_MIRROR: r[slot_scale] = -r[slot_scale]; break;
        case OP_LEVEL: level(); break;
        case OP_SIZE: resize(dvec3(r[a], r[b], r[c])); break;
        case OP_SLAB: if (!slab(z, r[a], r[b])) at = w; break;
        case OP_ZERO: if (r[a] == 0.0lf) at = z; break;
        case OP_SHOW: shown = r[a] != 0.0lf; break;
        case OP_EMIT: draw(int(z), w, n, dvec3(r[a], r[b], r[c])); break;
        case OP_CHILD: if (shown) make(z, key, rule, w, 0u, n); break;
        case OP_RANGE:
            if (shown && r[a] > 0.0lf)
                append(BLOCK | z, following, own_key, rule, uint(r[a]), w, 0u, n, false);
            break;
        case OP_COUNT: r[target] = copies_of(r[a]); break;
        case OP_LOOP:
            r[a] += 1.0lf;
            if (r[a] < r[b]) {
                at = z;
                if (n == 0u && spent > BUDGET) {
                    append(RESUME | (shown ? 0u : HIDDEN) | at, following, own_key, rule, 1u,
                           NONE, state_size, param_size, false);
                    return;
                }
            }
            break;
        case OP_FETCH: r[target] = sampled(code[z], r[a], r[b]); break;
        case OP_MEASURE: r[target] = measured(z); break;
        case OP_EXTRUDE: extrude(r[a], data[z]); break;
        case OP_FACES: r[target] = face_count(z); break;
        case OP_FACE: face(z, r[a]); break;
        case OP_ROTATE: rotate_scope(dvec3(r[a], r[b], r[c]), z); break;
        case OP_FLIP: flip(z); break;
        case OP_GEOMETRY: r[slot_geometry] = data[z]; break;
        case OP_RULE: rule = z; break;
        case OP_SHARE: share(z, r[a]); break;
        case OP_TAKE:
            if (taken == NONE) taken = z;
            at = w;
            break;
        case OP_CHOOSE:
            if (total > 1.0lf + 1e-9lf) trouble(TROUBLE_SHARES);
            if (taken == NONE) {
                none_taken(w);
                return;
            }
            at = code[z + 2u * taken];
            rule = code[z + 2u * taken + 1u];
            break;
        case OP_JUMP: at = z; break;
        case OP_DIFFER: r[target] = r[a] != r[b] ? 1.0lf : 0.0lf; break;
        default: trouble(TROUBLE_GEOMETRY);
        }
        if (given_up) return;
    }
}


double queued(uint record, uint word) {
    return packDouble2x32(uvec2(queue[word * queue_rows + record],
                                queue[(word + 1u) * queue_rows + record]));
}

// The record that a thread runs a copy of: the last one whose copies begin at it or before.
uint record_of(uint thread) {
    uint low = 0u, high = records;
    while (high - low > 1u) {
        uint middle = (low + high) / 2u;
        if (offsets[middle] <= thread) low = middle;
        else high = middle;
    }
    return low;
}

void main() {
    uint number = gl_GlobalInvocationID.x;
    if (number >= threads) return;
    uint thread = first_thread + number;
    uint record = whole != 0u ? thread : record_of(thread);
    copy_number = whole != 0u ? 0u : thread - offsets[record];
    uint entry = queue[HEADER_ENTRY * queue_rows + record];
    generation = queue[HEADER_GENERATION * queue_rows + record];
    own_key = uvec2(queue[HEADER_KEY0 * queue_rows + record],
                    queue[HEADER_KEY1 * queue_rows + record]);
    rule = queue[HEADER_RULE * queue_rows + record];
    node = first_record + record;
    sequence = 0u;
    spent = 0u;
    shown = true;
    given_up = false;
    for (uint place = 0u; place < state_size + param_size; place++)
        r[place] = queued(record, HEADER + 2u * place);
    uint at;
    if ((entry & RESUME) != 0u) {
        following = generation;
        shown = (entry & HIDDEN) == 0u;
        at = entry & ~(RESUME | HIDDEN);
    } else if ((entry & BLOCK) != 0u) {
        following = generation;
        uint block = blocks + (entry & ~BLOCK) * 2u;
        at = code[block];
        r[code[block + 1u]] = from_word(copy_number);
    } else {
        bool sound = true;
        uint last = state_size + code[symbols + entry * ENTRY + ENTRY_ARITY];
        for (uint place = state_size; place < last; place++) sound = sound && is_finite(r[place]);
        for (uint field = 0u; field < (planar != 0u ? 3u : 7u); field++)
            sound = sound && is_finite(r[field]);
        at = entered(entry, generation);
        if (!sound) trouble(TROUBLE_NOT_FINITE);
    }
    if (at != NONE && !given_up) run(at);
    atomicAdd(counts[COUNT_ENDED], 1u);
}
