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

uint spent;     // instructions so far, and words that were moved
bool complete;  // the thread came to an end: some drivers break loops off without a word

#ifdef PER_SEED

// A thread's part of the stack, word by word beside those of the others: how many frames there are
// (NONE: it is done), how much it has made, its state, then frames: where to go on, the rule, the
// generation of what it makes, both keys, whether anything is made, registers, and, where children
// fork, the state.

uint thread_number;
uint depth;

void keep(uint word, uint value) { stack[word * threads + thread_number] = value; }

uint kept(uint word) { return stack[word * threads + thread_number]; }

void keep_number(uint word, double value) {
    uvec2 words = unpackDouble2x32(value);
    keep(word, words.x);
    keep(word + 1u, words.y);
}

double kept_number(uint word) { return packDouble2x32(uvec2(kept(word), kept(word + 1u))); }

void push(uint at) {
    uint frame = 2u + 2u * state_size + depth * frame_words;
    keep(frame, at);
    keep(frame + 1u, rule);
    keep(frame + 2u, following);
    keep(frame + 3u, own_key.x);
    keep(frame + 4u, own_key.y);
    keep(frame + 5u, key.x);
    keep(frame + 6u, key.y);
    keep(frame + 7u, shown ? 1u : 0u);
    for (uint place = 0u; place < registers; place++)
        keep_number(frame + 8u + 2u * place, r[state_size + place]);
    if (forks != 0u)
        for (uint field = 0u; field < state_size; field++)
            keep_number(frame + 8u + 2u * (registers + field), r[field]);
    depth++;
    spent += registers + state_size;
}

uint pop(bool with_state) {
    depth--;
    uint frame = 2u + 2u * state_size + depth * frame_words;
    rule = kept(frame + 1u);
    following = kept(frame + 2u);
    own_key = uvec2(kept(frame + 3u), kept(frame + 4u));
    key = uvec2(kept(frame + 5u), kept(frame + 6u));
    shown = kept(frame + 7u) != 0u;
    for (uint place = 0u; place < registers; place++)
        r[state_size + place] = kept_number(frame + 8u + 2u * place);
    if (with_state)
        for (uint field = 0u; field < state_size; field++)
            r[field] = kept_number(frame + 8u + 2u * (registers + field));
    spent += registers + state_size;
    return kept(frame);
}

// Leave off before the instruction at a place; another dispatch goes on there.
void leave_off(uint at) {
    push(at);
    keep(0u, depth);
    keep(1u, sequence);
    for (uint field = 0u; field < state_size; field++) keep_number(2u + 2u * field, r[field]);
    atomicAdd(counts[COUNT_RECORDS], 1u);
    complete = true;
}

uint resume() {
    depth = kept(0u);
    sequence = kept(1u);
    uint at = pop(false);
    for (uint field = 0u; field < state_size; field++) r[field] = kept_number(2u + 2u * field);
    return at;
}

// Where the code of a child goes on; its arguments are on their way.
uint called(uint symbol, uvec2 its_key, uint parameters) {
    bool sound = true;
    own_key = its_key;
    for (uint place = 0u; place < parameters; place++) {
        r[state_size + place] = r[REGISTERS + place];
        sound = sound && is_finite(r[state_size + place]);
    }
    if (!sound) trouble(TROUBLE_NOT_FINITE);
    spent += parameters;
    return entered(symbol, following);
}

#else

// Leave off before the instruction at a place; another thread goes on there.
void leave_off(uint at) {
    append(RESUME | (shown ? 0u : HIDDEN) | at, following, own_key, rule, 1u, NONE, state_size,
           param_size, false);
    complete = true;
}

#endif

// No production takes a shape: it stays as it is, with a key of its own, or is an error. Where its
// code goes on; NONE: it ends here.
uint none_taken(uint symbol) {
    if (steps == NONE && following < FINAL) {
        trouble(TROUBLE_NO_PRODUCTION);
        return NONE;
    }
    uint parameters = code[symbols + symbol * ENTRY + ENTRY_ARITY];
    uvec2 its_key = mixed(own_key, CHOICE_SITE);
#ifdef PER_SEED
    atomicAdd(counts[COUNT_SHAPES], 1u);
    rule = NONE;
    if (!worth_making(symbol)) return NONE;
    for (uint place = 0u; place < parameters; place++)
        r[REGISTERS + place] = r[state_size + place];
    return called(symbol, its_key, parameters);
#else
    make(symbol, its_key, NONE, NONE, state_size, parameters);
    return NONE;
#endif
}

void run(uint at) {
    for (;;) {
        uint word = code[at], more = code[at + 1u], z = code[at + 2u], w = code[at + 3u];
        uint target = word >> 8 & 255u, a = word >> 16 & 255u, b = word >> 24;
        uint c = more & 255u, d = more >> 8 & 255u, n = more >> 24;
        at += 4u;
        spent++;
        switch (word & 255u) {
        case OP_END:
#ifdef PER_SEED
            if (depth > 0u) {
                at = pop(forks != 0u);
                break;
            }
            keep(0u, NONE);
#endif
            complete = true;
            return;
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
        case OP_KEY:
            if (n != 0u && spent > budget && resumable != 0u) {
                leave_off(at - 4u);
                return;
            }
            key = z == NONE ? own_key : mixed(own_key, z);
            break;
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
        case OP_EMIT: {
            bool drawn_here = draw(int(z), w, n, dvec3(r[a], r[b], r[c]));
#ifdef PER_SEED
            if (!drawn_here) {
                leave_off(at - 4u);
                return;
            }
#endif
            break;
        }
        case OP_CHILD:
            if (!shown) break;
#ifdef PER_SEED
            if (depth >= stack_slots) atomicMax(counts[COUNT_COPIES], 1u);
            if (depth >= stack_slots) {
                leave_off(at - 4u);
                return;
            }
            atomicAdd(counts[COUNT_SHAPES], 1u);
            if (!worth_making(z)) break;
            for (uint place = 0u; place < n; place++) r[REGISTERS + place] = r[code[w + place]];
            if (d == 0u) push(at);
            at = called(z, key, n);
            if (at == NONE) at = 0u;  // where an END stands
#else
            make(z, key, rule, w, 0u, n);
#endif
            break;
        case OP_RANGE:
            if (shown && r[a] > 0.0lf)
                append(BLOCK | z, following, own_key, rule, uint(r[a]), w, 0u, n, false);
            break;
        case OP_COUNT: r[target] = copies_of(r[a]); break;
        case OP_LOOP:
            r[a] += 1.0lf;
            if (r[a] < r[b]) {
                at = z;
                if (n == 0u && spent > budget) {
                    leave_off(at);
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
                at = none_taken(w);
#ifdef PER_SEED
                if (at != NONE) break;
                if (depth > 0u) {
                    at = pop(forks != 0u);
                    break;
                }
                keep(0u, NONE);
#endif
                complete = true;
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

#ifndef PER_SEED
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
#endif

void main() {
    uint number = gl_GlobalInvocationID.x;
    if (number >= threads) return;
    uint thread = first_thread + number;
#ifdef PER_SEED
    uint record = thread;
    copy_number = 0u;
    thread_number = number;
    depth = 0u;
    if (resuming != 0u && kept(0u) == NONE) {
        atomicAdd(counts[COUNT_ENDED], 1u);
        return;
    }
#else
    uint record = whole != 0u ? thread : record_of(thread);
    copy_number = whole != 0u ? 0u : thread - offsets[record];
#endif
    uint entry = queue[HEADER_ENTRY * queue_rows + record];
    generation = queue[HEADER_GENERATION * queue_rows + record];
    own_key = uvec2(queue[HEADER_KEY0 * queue_rows + record],
                    queue[HEADER_KEY1 * queue_rows + record]);
    rule = queue[HEADER_RULE * queue_rows + record];
    node = first_record + record;
    sequence = 0u;
    spent = 0u;
    complete = false;
    shown = true;
    given_up = false;
    for (uint place = 0u; place < state_size + param_size; place++)
        r[place] = queued(record, HEADER + 2u * place);
    uint at;
#ifdef PER_SEED
    if (resuming != 0u) {
        at = resume();
    } else
#endif
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
#ifdef PER_SEED
    if (at == NONE) keep(0u, NONE);
#endif
    if (at == NONE) complete = true;
    else if (!given_up) run(at);
    if (complete) atomicAdd(counts[COUNT_ENDED], 1u);
}
