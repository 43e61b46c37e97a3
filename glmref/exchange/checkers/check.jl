# Order of a Runge-Kutta tableau over rooted trees, through order 8. One file, no dependencies.
#
#   julia check.jl rk4.txt gauss-2.txt        one line of JSON a file
#   include("check.jl"); GlmrefCheck.check(text)
#
# A text has the rows of A, then `b: ...`, and where there are any `c: ...` and `b_hat NAME: ...`.
# Entries are apart by blanks or commas, and are made of + - * / ( ) sqrt(x) root(x,n). A number with
# a point is exact, unless `digits: N` stands above: then it is known to one unit of the N-th digit.
# Rational tableaux are decided in fractions of whole numbers of any size. Others are enclosed in
# intervals of 320 bits: what fails is proved to fail, and what does not is right to `within`. CC0 1.0.
module GlmrefCheck

const BITS = 320
const ONE = big(1) << BITS
const MOST = 8
const MOST_STAGES = 60
const NEAR = 1e-9

const Exact = Rational{BigInt}

"An interval, its ends in units of 2^-BITS."
struct Interval
    lo::BigInt
    hi::BigInt
end

const Value = Union{Exact,Interval}

box(x::Interval) = x
box(x::Exact) = Interval(fld(numerator(x) << BITS, denominator(x)), cld(numerator(x) << BITS, denominator(x)))
isnil(x::Exact) = iszero(x)
isnil(x::Interval) = iszero(x.lo) && iszero(x.hi)

add(a::Exact, b::Exact) = a + b
add(a::Value, b::Value) = (x = box(a); y = box(b); Interval(x.lo + y.lo, x.hi + y.hi))
minus(a::Exact) = -a
minus(a::Interval) = Interval(-a.hi, -a.lo)
mul(a::Exact, b::Exact) = a * b
function mul(a::Interval, b::Exact)  # a fraction, which may be huge or tiny
    ends = (a.lo * numerator(b), a.hi * numerator(b))
    return Interval(fld(minimum(ends), denominator(b)), cld(maximum(ends), denominator(b)))
end
mul(a::Exact, b::Interval) = mul(b, a)
function mul(a::Interval, b::Interval)
    p = (a.lo * b.lo, a.lo * b.hi, a.hi * b.lo, a.hi * b.hi)
    return Interval(fld(minimum(p), ONE), cld(maximum(p), ONE))
end
function inverse(b::Exact)
    iszero(b) && error("a division by zero")
    return inv(b)
end
function inverse(b::Interval)
    b.lo <= 0 <= b.hi && error("a division by zero")
    return Interval(fld(ONE * ONE, b.hi), cld(ONE * ONE, b.lo))
end

"The largest r with r^k <= x."
function wholeroot(x::BigInt, k::Int)
    x < 2 && return x
    r = big(1) << (div(ndigits(x, base=2), k) + 1)
    while true
        next = div((k - 1) * r + div(x, r^(k - 1)), k)
        next >= r && return r
        r = next
    end
end
function root(x::Value, k::Int)
    1 <= k <= 60 || error("a root of a degree that is not 1 to 60")
    (x isa Exact ? x < 0 : x.lo < 0) && error("a root of a negative number")
    if x isa Exact
        n, d = wholeroot(numerator(x), k), wholeroot(denominator(x), k)
        n^k == numerator(x) && d^k == denominator(x) && return n // d
    end
    y = box(x)
    shift = BITS * (k - 1)
    return Interval(wholeroot(y.lo << shift, k), wholeroot(y.hi << shift, k) + 1)
end

function decimal(text::AbstractString, digits::Int)
    parts = split(text, ".")
    places = length(parts) == 1 ? 0 : length(parts[2])
    value = parse(BigInt, replace(text, "." => "")) // big(10)^places
    (digits == 0 || length(parts) == 1) && return value
    places < digits && error("'$text' has fewer than $digits digits")
    iszero(value) && return value
    unit, at = box(big(1) // big(10)^digits), box(value)
    return Interval(at.lo - unit.hi, at.hi + unit.hi)
end

mutable struct Reader
    tokens::Vector{String}
    at::Int
    digits::Int
end
peek(r::Reader) = r.at <= length(r.tokens) ? r.tokens[r.at] : "the end"
function want(r::Reader, x::String)
    peek(r) == x || error("'$(peek(r))' in place of '$x'")
    r.at += 1
end
function atom(r::Reader)::Value
    token = peek(r)
    r.at += 1
    occursin(r"^[0-9.]*[0-9][0-9.]*$", token) && return decimal(token, r.digits)
    token in ("(", "sqrt", "root") || error("'$token' is not read")
    token == "(" || want(r, "(")
    inside = sum_of(r)
    degree = 2
    if token == "root"
        want(r, ",")
        occursin(r"^[0-9]{1,2}$", peek(r)) || error("a root without a whole degree")
        degree = parse(Int, peek(r))
        r.at += 1
    end
    want(r, ")")
    return token == "(" ? inside : root(inside, degree)
end
function factor(r::Reader)::Value
    sign = peek(r)
    sign in ("+", "-") || return atom(r)
    r.at += 1
    return sign == "-" ? minus(factor(r)) : factor(r)
end
function chain(r::Reader, signs::Tuple{String, String}, part, join, opposite)::Value
    found = part(r)
    while peek(r) in signs
        r.at += 1
        plain = r.tokens[r.at - 1] == signs[1]
        found = join(found, plain ? part(r) : opposite(part(r)))
    end
    return found
end
product_of(r::Reader)::Value = chain(r, ("*", "/"), factor, mul, inverse)
sum_of(r::Reader)::Value = chain(r, ("+", "-"), product_of, add, minus)
function number(text::AbstractString, digits::Int)::Value
    tokens = [String(m.match) for m in eachmatch(r"[0-9]+\.[0-9]*|\.[0-9]+|[0-9]+|[a-z]+|\S", text)]
    r = Reader(tokens, 1, digits)
    found = sum_of(r)
    r.at <= length(tokens) && error("'$(peek(r))' behind the end of a number")
    return found
end

"Entries of a line: apart by blanks, commas and semicolons outside of brackets."
function entries(line::AbstractString)
    found, depth = [""], 0
    for letter in line
        depth += letter == '(' ? 1 : letter == ')' ? -1 : 0
        if depth <= 0 && (isspace(letter) || letter in (',', ';'))
            push!(found, "")
        else
            found[end] *= letter
        end
    end
    return filter(!isempty, found)
end

function read_tableau(text::AbstractString)
    A, rows, c, digits = Vector{Value}[], Pair{String,Vector{Value}}[], nothing, 0
    for full in split(text, "\n")
        line = strip(first(split(full, "#")))
        isempty(line) && continue
        parts = split(line, ":"; limit=2)
        name = length(parts) == 1 ? "" : String(strip(parts[1]))
        if name == "digits"
            known = tryparse(Int, strip(parts[2]))
            (known !== nothing && 1 <= known <= 150) || error("`digits` must be a whole number from 1 to 150")
            digits = known
            continue
        end
        place = isempty(name) ? "row $(length(A) + 1) of A" : name
        row = Value[]
        for (k, entry) in enumerate(entries(parts[end]))
            length(entry) > 500 && error("$place: entry $k has more than 500 characters")
            try
                push!(row, number(entry, digits))
            catch problem
                problem isa ErrorException || rethrow()
                error("$place, entry $k: $(problem.msg)")
            end
        end
        if isempty(name)
            push!(A, row)
        elseif name == "c"
            c = row
        elseif name == "b" || startswith(name, "b_hat")
            rest = name == "b" ? "b" : String(strip(name[6:end]))
            push!(rows, (isempty(rest) ? "b_hat" : rest) => row)
        else
            error("'$name' is none of b, c, b_hat NAME, digits")
        end
    end
    s = length(A)
    1 <= s <= MOST_STAGES || error("A must have 1 to $MOST_STAGES rows, got $s")
    any(x -> first(x) == "b", rows) || error("the row `b: ...` is missing")
    listed = [["row $k of A" => row for (k, row) in enumerate(A)]; rows]
    c === nothing || push!(listed, "c" => c)
    for (name, row) in listed
        length(row) == s || error("$name has $(length(row)) entries and must have $s")
    end
    return A, rows, c
end

"A rooted tree by its branches, which are places in the list; the leaf `t` is the time."
struct Tree
    kids::Vector{Int}
    n::Int
    gamma::BigInt
    text::String
    time::Bool
end

function trees(timed::Bool)
    pool = timed ? [Tree(Int[], 1, big(1), "t", true)] : Tree[]
    for n in 1:MOST
        level = Tree[]
        function grow(left, from, kids)
            if left == 0
                gamma = n * prod(BigInt[pool[k].gamma for k in kids])
                text = isempty(kids) ? "o" : "[" * join([pool[k].text for k in kids]) * "]"
                push!(level, Tree(kids, n, gamma, text, false))
            end
            for k in from:length(pool)
                pool[k].n <= left || break
                grow(left - pool[k].n, k, [kids; k])
            end
        end
        grow(n - 1, 1, Int[])
        append!(pool, level)
    end
    return pool
end

dot(x, y) = foldl((total, k) -> isnil(x[k]) ? total : add(total, mul(x[k], y[k])), eachindex(x); init=big(0) // big(1))

size_of(x::Exact) = abs(x)
size_of(x::Interval) = max(abs(x.lo), abs(x.hi)) // ONE
fails(x::Exact) = !iszero(x)
fails(x::Interval) = x.lo > 0 || x.hi < 0
middle(x::Exact) = x
middle(x::Interval) = (x.lo + x.hi) // (2 * ONE)

"Three digits of a fraction."
function scientific(x::Exact)
    iszero(x) && return "0"
    y, e = abs(x), 0
    e = ndigits(numerator(y)) - ndigits(denominator(y))
    y < (e >= 0 ? big(10)^e // 1 : 1 // big(10)^(-e)) && (e -= 1)
    m = string(round(BigInt, 2 >= e ? y * big(10)^(2 - e) : y / big(10)^(e - 2), RoundNearestTiesUp))
    length(m) > 3 && (e += 1)
    return (x < 0 ? "-" : "") * m[1:1] * "." * m[2:3] * "e" * string(e)
end

"Orders of the rows of a tableau, as (stages, exact, row_sums, rows)."
function check(text::AbstractString)
    A, rows, c = read_tableau(text)
    s = length(A)
    rational = all(x -> x isa Exact, [vcat(A...); vcat([row for (_, row) in rows]...); c === nothing ? Value[] : c])
    off = c === nothing ? Value[] : Value[add(c[i], minus(foldl(add, A[i]))) for i in 1:s]
    apart = any(fails, off)
    listed = trees(apart)
    weight = Vector{Vector{Value}}(undef, length(listed))
    found = Dict(name => Dict{String,Any}("failing" => 0, "tree" => nothing, "residual" => nothing, "failed" => 0, "close" => MOST + 1, "within" => big(0) // big(1)) for (name, _) in rows)
    for (m, tree) in enumerate(listed)
        if tree.time
            weight[m] = c
            continue
        end
        product = Value[foldl((x, kid) -> mul(x, weight[kid][i]), tree.kids; init=big(1) // big(1)) for i in 1:s]
        tree.n < MOST && (weight[m] = Value[dot(row, product) for row in A])
        for (name, row) in rows
            x, about = add(dot(row, product), big(-1) // tree.gamma), found[name]
            if fails(x) && about["failed"] == 0
                about["failed"], about["tree"], about["residual"] = tree.n, tree.text, scientific(middle(x))
            end
            fails(x) && about["failed"] == tree.n && (about["failing"] += 1)
            about["failed"] == 0 && !rational && (about["within"] = max(about["within"], size_of(x)))
            size_of(x) > NEAR && (about["close"] = min(about["close"], tree.n))
        end
    end
    report = [(name, found[name]) for (name, _) in rows]
    return (stages=s, exact=rational, row_sums=c === nothing ? nothing : !apart, rows=report)
end

quoted(x) = x === nothing ? "null" : "\"" * replace(string(x), "\\" => "\\\\", "\"" => "\\\"") * "\""

function json(report)
    rows = map(report.rows) do (name, x)
        order = x["failed"] == 0 ? MOST : x["failed"] - 1
        values = [
            "\"order\":$order", "\"capped\":$(x["failed"] == 0)", "\"failing\":$(x["failing"])",
            "\"tree\":" * quoted(x["tree"]), "\"residual\":" * quoted(x["residual"]),
            "\"within\":" * quoted(scientific(x["within"])), "\"near\":$(x["close"] - 1)",
        ]
        quoted(name) * ":{" * join(values, ",") * "}"
    end
    sums = report.row_sums === nothing ? "null" : string(report.row_sums)
    return "{\"stages\":$(report.stages),\"exact\":$(report.exact),\"row_sums\":$sums,\"rows\":{" * join(rows, ",") * "}}"
end

function main(paths)
    code = 0
    for path in paths
        try
            println(json(check(read(path, String))))
        catch problem
            problem isa ErrorException || rethrow()
            println("{\"error\":", quoted(problem.msg), "}")
            code = 2
        end
    end
    return code
end

end

if abspath(PROGRAM_FILE) == @__FILE__
    exit(GlmrefCheck.main(ARGS))
end
