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
            if (following > most_generations) trouble(TROUBLE_LIMIT);
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
// generation of what it makes, both keys, whether anything is there, registers, and, where children
// fork, the state.

uint thread_number;
uint depth;
bool absent;  // the whole shape stands in a hole, and nothing that it makes is there

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
    keep(frame + 7u, (shown ? 1u : 0u) | (absent ? 2u : 0u));
    uint many = registers + (forks != 0u ? state_size : 0u);
    for (uint place = 0u; place < many; place++) {
        uint own = place < registers ? state_size + place : place - registers;
        keep_number(frame + 8u + 2u * place, r[own]);
    }
    depth++;
    spent += many / 8u;
}

uint pop(bool with_state) {
    depth--;
    uint frame = 2u + 2u * state_size + depth * frame_words;
    rule = kept(frame + 1u);
    following = kept(frame + 2u);
    own_key = uvec2(kept(frame + 3u), kept(frame + 4u));
    key = uvec2(kept(frame + 5u), kept(frame + 6u));
    shown = (kept(frame + 7u) & 1u) != 0u;
    absent = (kept(frame + 7u) & 2u) != 0u;
    uint many = registers + (with_state ? state_size : 0u);
    for (uint place = 0u; place < many; place++) {
        uint own = place < registers ? state_size + place : place - registers;
        r[own] = kept_number(frame + 8u + 2u * place);
    }
    spent += many / 8u;
    return kept(frame);
}

#endif

// What an instruction leaves to be done after it, once for all of them: these parts are long, and a
// compiler writes them out wherever they are called.
const uint DONE = 0u;
const uint MAKE = 1u;     // a record
const uint STOP = 2u;     // leave off; another dispatch goes on
const uint RETURN = 3u;   // the code of the shape has ended
const uint STAY = 4u;     // no production takes the shape
#ifdef PER_SEED
const uint RESUMED = 5u;  // go on where the thread left off
const uint CALL = 6u;     // the child that an instruction makes
#endif

// The thread leaves off before the instruction at a place. Without stacks the rest is a record.
void describe_rest(uint at) {
    record = Record(RESUME | (shown ? 0u : HIDDEN) | at, following, own_key, rule, 1u, NONE,
                    state_size, param_size, false);
}

void run(uint at, uint action) {
    for (;;) {
        uint word = code[at], more = code[at + 1u], z = code[at + 2u], w = code[at + 3u];
        uint target = word >> 8 & 255u, a = word >> 16 & 255u, b = word >> 24;
        uint c = more & 255u, d = more >> 8 & 255u, n = more >> 24;
        moves = false;
        spins = false;
        circles = false;
        spent++;
        uint here = at;
        if (action == DONE) {
            at += 4u;
            switch (word & 255u) {
            case OP_END: action = RETURN; break;
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
                if (n != 0u && spent > budget && resumable != 0u) action = STOP;
                else key = z == NONE ? own_key : mixed(own_key, z);
                break;
            case OP_MIX: key = mixed(key, to_word(r[a])); break;
            case OP_UNIFORM: r[target] = draw_of(key); break;
            case OP_ROW:
                r[target] = data[z + (r[a] > 0.0lf ? uint(min(r[a], double(w - 1u))) : 0u)];
                break;
            case OP_MOVE: go_by(dvec3(r[a], r[b], r[c])); break;
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
#ifdef PER_SEED
            case OP_SHOW: shown = r[a] != 0.0lf && !absent; break;
#else
            case OP_SHOW: shown = r[a] != 0.0lf; break;
#endif
            case OP_EMIT:
#ifdef PER_SEED
                if (!draw(int(z), w, n, dvec3(r[a], r[b], r[c]))) action = STOP;
#else
                draw(int(z), w, n, dvec3(r[a], r[b], r[c]));  // its need is counted to the end
#endif
                break;
            case OP_CHILD:
#ifdef PER_SEED
                // What stands in a hole is not there, but the turtle goes on behind it.
                if (!shown && (forks != 0u || on_cpu(z))) break;
#else
                if (!shown) break;
#endif
                record = Record(z, following, key, rule, 1u, w, 0u, n, on_cpu(z));
#ifdef PER_SEED
                if (record.back) {
                    if (worth_making(z)) action = MAKE;
                } else if (depth >= stack_slots) {
                    atomicMax(counts[COUNT_COPIES], 1u);
                    action = STOP;
                    break;
                } else if (worth_making(z)) {
                    action = CALL;
                }
#else
                if (worth_making(z)) action = MAKE;
#endif
                if (shown) count_shape();
                break;
            case OP_RANGE:
                if (!shown || !(r[a] > 0.0lf)) break;
                record = Record(BLOCK | z, following, own_key, rule, uint(r[a]), w, 0u, n, false);
                action = MAKE;
                break;
            case OP_COUNT: r[target] = copies_of(r[a]); break;
            case OP_LOOP:
                r[a] += 1.0lf;
                if (!(r[a] < r[b])) break;
                at = z;
                if (n == 0u && spent > budget) {
                    here = at;
                    action = STOP;
                }
                break;
            case OP_FETCH: r[target] = sampled(code[z], r[a], r[b]); break;
            case OP_MEASURE: r[target] = measured(z); break;
            case OP_EXTRUDE: extrude(r[a], data[z]); break;
            case OP_FACES: r[target] = face_count(z); break;
            case OP_FACE: face(z, r[a]); break;
            case OP_CENTER: center(z, n != 0u); break;
            case OP_FLIP: flip(z); break;
            case OP_GEOMETRY: r[slot_geometry] = data[z]; break;
            case OP_RULE: blamed = rule = z; break;
            case OP_SHARE: share(z, r[a]); break;
            case OP_TAKE:
                if (taken == NONE) taken = z;
                at = w;
                break;
            case OP_CHOOSE:
                if (total > 1.0lf + 1e-9lf) trouble(TROUBLE_SHARES);
                if (taken == NONE) {
                    action = STAY;
                    break;
                }
                at = code[z + 2u * taken];
                blamed = rule = code[z + 2u * taken + 1u];
                break;
            case OP_JUMP: at = z; break;
            case OP_DIFFER: r[target] = r[a] != r[b] ? 1.0lf : 0.0lf; break;
            default: trouble(TROUBLE_GEOMETRY);
            }
        }
        if (given_up) return;
        if (moves || spins) move_and_spin();
        if (action == DONE) continue;
        if (action == STAY) {  // the shape stays, with a key of its own, or is an error
            if (steps == NONE && following < FINAL) {
                trouble(TROUBLE_NO_PRODUCTION);
                return;
            }
            if (shown) count_shape();
            record = Record(w, following, mixed(own_key, CHOICE_SITE), NONE, 1u, NONE, state_size,
                            code[symbols + w * ENTRY + ENTRY_ARITY], on_cpu(w));
            rule = NONE;
            at = 0u;  // where an END stands
            action = DONE;
            if (worth_making(w)) {
#ifdef PER_SEED
                d = 1u;
                action = record.back ? MAKE : CALL;
#else
                action = MAKE;
#endif
            }
        }
#ifdef PER_SEED
        if (action == MAKE && !append()) {
            atomicAdd(counts[COUNT_SHAPES], NONE);  // it is counted when it is made
            action = STOP;
        } else if (action == MAKE) {
            action = DONE;
        }
        if (action == STOP || (action == CALL && d == 0u)) push(action == STOP ? here : at);
        if (action == STOP) {
            keep(0u, depth);
            keep(1u, sequence);
            for (uint field = 0u; field < state_size; field++)
                keep_number(2u + 2u * field, r[field]);
            atomicAdd(counts[COUNT_RECORDS], 1u);
            complete = true;
            return;
        }
        if (action == CALL) {
            absent = !shown;
            own_key = record.key;
            bool sound = true;
            for (uint place = 0u; place < record.parameters; place++) {
                uint from = record.list == NONE ? record.first + place : code[record.list + place];
                r[REGISTERS + place] = r[from];
                sound = sound && is_finite(r[from]);
            }
            for (uint place = 0u; place < record.parameters; place++)
                r[state_size + place] = r[REGISTERS + place];
            if (!sound) {
                trouble(TROUBLE_NOT_FINITE);
                return;
            }
            spent += record.parameters / 4u;
            at = entered(record.entry, following);
            if (at == NONE) at = 0u;
        }
        if (action == RETURN && depth == 0u) {
            keep(0u, NONE);
            complete = true;
            return;
        }
        if (action == RETURN || action == RESUMED) at = pop(action == RETURN && forks != 0u);
        if (action == RESUMED)
            for (uint field = 0u; field < state_size; field++)
                r[field] = kept_number(2u + 2u * field);
#else
        if (action == STOP) describe_rest(here);
        if (action == MAKE || action == STOP) append();
        if (action == RETURN || action == STOP) {
            complete = true;
            return;
        }
#endif
        action = DONE;
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
    absent = false;
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
    blamed = entry < BLOCK ? productions + 1u + entry : rule;
    taken = NONE;
    total = 0.0lf;
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
    uint action = resuming != 0u ? RESUMED : DONE;
    if (resuming != 0u) {
        depth = kept(0u);
        sequence = kept(1u);
        at = 0u;
    } else
#else
    uint action = DONE;
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
    else if (!given_up) run(at, action);
    if (complete) atomicAdd(counts[COUNT_ENDED], 1u);
}
