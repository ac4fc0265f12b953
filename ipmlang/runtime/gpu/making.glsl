// What a thread makes: records of shapes, and terminals.

void put(uint row, uint word, uint rows, uint value, bool back) {
    if (back) returned[word * rows + row] = value;
    else next[word * rows + row] = value;
}

void put_number(uint row, uint word, uint rows, double value, bool back) {
    uvec2 words = unpackDouble2x32(value);
    put(row, word, rows, words.x, back);
    put(row, word + 1u, rows, words.y, back);
}

// A record at the end of the next queue, or of the table of those that go back to the CPU; `list`
// names the registers of its parameters, NONE: those from `first` on.
void append(uint entry, uint generation, uvec2 its_key, uint its_rule, uint many, uint list,
            uint first, uint parameters, bool back) {
    uint row = atomicAdd(counts[back ? COUNT_RETURNED : COUNT_RECORDS], 1u);
    if (back) row += returned_first;
    else if (atomicAdd(counts[COUNT_COPIES], many) + many < many) trouble(TROUBLE_COUNT);
    uint number = sequence++;
    uint rows = back ? returned_rows : next_rows;
    if (row >= rows) return;
    put(row, HEADER_ENTRY, rows, entry, back);
    put(row, HEADER_GENERATION, rows, generation, back);
    put(row, HEADER_KEY0, rows, its_key.x, back);
    put(row, HEADER_KEY1, rows, its_key.y, back);
    put(row, HEADER_RULE, rows, its_rule, back);
    put(row, HEADER_PARENT, rows, node, back);
    put(row, HEADER_COPY, rows, copy_number, back);
    put(row, HEADER_SEQUENCE, rows, number, back);
    put(row, HEADER_COUNT, rows, many, back);
    for (uint field = 0u; field < state_size; field++)
        put_number(row, HEADER + 2u * field, rows, r[field], back);
    for (uint place = 0u; place < parameters; place++) {
        double value = r[list == NONE ? first + place : code[list + place]];
        put_number(row, HEADER + 2u * (state_size + place), rows, value, back);
    }
}

// Draw a terminal; false where the table is full.
bool draw(int asset, uint symbol, uint kind, dvec3 given) {
    if (!shown) return true;
    dvec3 size = dvec3(0.0lf);
    if (kind == 1u) size = given;
    if (asset == -3 && slot_geometry != NONE) {
        size = dvec3(r[slot_size], r[slot_size + 1u], r[slot_size + 2u]);
        if (r[slot_geometry] == 0.0lf) {
            atomicAdd(counts[COUNT_NOTES + productions + 1u + symbol], 1u);
            return true;
        }
    }
    bool sound = is_finite(size.x) && is_finite(size.y) && is_finite(size.z);
    for (uint field = 0u; field < (planar != 0u ? 3u : 7u); field++)
        sound = sound && is_finite(r[field]);
    if (!sound || !is_finite(scale_factor())) {
        trouble(TROUBLE_NOT_FINITE);
        return true;
    }
    uint row = terminal_first + atomicAdd(counts[COUNT_TERMINALS], 1u);
    if (row >= terminal_rows) return false;
    uint number = sequence++;
    terminals[TERMINAL_PARENT * terminal_rows + row] = node;
    terminals[TERMINAL_COPY * terminal_rows + row] = copy_number;
    terminals[TERMINAL_SEQUENCE * terminal_rows + row] = number;
    terminals[TERMINAL_SYMBOL * terminal_rows + row] = symbol;
    terminals[TERMINAL_ASSET * terminal_rows + row] = uint(asset);
    terminals[TERMINAL_RULE * terminal_rows + row] = rule;
    terminals[TERMINAL_KEY0 * terminal_rows + row] = key.x;
    terminals[TERMINAL_KEY1 * terminal_rows + row] = key.y;
    for (uint axis = 0u; axis < 3u; axis++) {
        uvec2 words = unpackDouble2x32(size[axis]);
        terminals[(TERMINAL + 2u * axis) * terminal_rows + row] = words.x;
        terminals[(TERMINAL + 2u * axis + 1u) * terminal_rows + row] = words.y;
    }
    for (uint field = 0u; field < state_size; field++) {
        uvec2 words = unpackDouble2x32(r[field]);
        terminals[(TERMINAL + 6u + 2u * field) * terminal_rows + row] = words.x;
        terminals[(TERMINAL + 6u + 2u * field + 1u) * terminal_rows + row] = words.y;
    }
    return true;
}

// A child: nothing can come of a barren symbol, which is counted all the same.
bool worth_making(uint symbol) {
    uint entry = symbols + symbol * ENTRY;
    if (code[entry + ENTRY_MEANING] != NONE) return true;
    if (code[entry + ENTRY_INTERPRETATIONS] != NONE && following < FINAL) return true;
    if (code[entry + ENTRY_PRODUCTIONS] == NONE || following >= FINAL) return false;
    return steps == NONE || following < steps;
}

void make(uint symbol, uvec2 its_key, uint its_rule, uint list, uint first, uint parameters) {
    atomicAdd(counts[COUNT_SHAPES], 1u);
    if (!worth_making(symbol)) return;
    bool back = (code[symbols + symbol * ENTRY + ENTRY_FLAGS] & ON_CPU) != 0u;
    append(symbol, following, its_key, its_rule, 1u, list, first, parameters, back);
}

double copies_of(double limit) {
    if (!is_finite(limit)) {
        if (shown) trouble(TROUBLE_COUNT);
        return 0.0lf;
    }
    double found = ceil(limit - 1e-9lf * max(1.0lf, abs(limit)));
    if (found > 5e7lf) trouble(TROUBLE_COUNT);
    return max(found, 0.0lf);
}
