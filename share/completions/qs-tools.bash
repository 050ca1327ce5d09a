# bash completion for the programs of qs-tools; one file for all, it reads the program's own --help.

_qs_tools_option_help() { "$1" "${@:2}" --help 2>/dev/null; }

_qs_tools() {
    local program=$1 current=$2 previous=$3 help words
    COMPREPLY=()

    # A subcommand, as in `qs-path orbit`, has a help of its own.
    local subcommand=() word
    for word in "${COMP_WORDS[@]:1:COMP_CWORD-1}"; do
        [[ $word == -* ]] || { subcommand=("$word"); break; }
    done
    help=$(_qs_tools_option_help "$program")
    local subcommands
    subcommands=$(sed -n '/^S[uU][bB][cC][oO][mM][mM][aA][nN][dD][sS]:/,/^[^ ]/{s/^  \([a-z][a-z-]*\).*/\1/p}' <<<"$help")
    if [[ ${#subcommand[@]} -gt 0 ]] && grep -qx -- "${subcommand[0]}" <<<"$subcommands"; then
        help+=$'\n'$(_qs_tools_option_help "$program" "${subcommand[0]}")
        subcommands=
    fi

    # An option that takes one of a few words shows them as {a,b,c}.
    if [[ $previous == -* ]]; then
        local line choices
        line=$(grep -E -- "(^|[ ,])$previous([ ,=]|\$)" <<<"$help" | head -n 1)
        choices=$(sed -n 's/.*[{(]\([a-z0-9-]*\([,|][a-z0-9-]*\)\{1,\}\)[})].*/\1/p' <<<"$line" | tr ',|' '  ')
        if [[ -n $choices ]]; then
            COMPREPLY=($(compgen -W "$choices" -- "$current"))
            return
        fi
    fi
    if [[ $current == -* ]]; then
        words=$(grep -oE -- '(^|[ ,])--[a-z][a-z0-9-]*' <<<"$help" | tr -d ' ,' | sort -u)
        COMPREPLY=($(compgen -W "$words" -- "$current"))
    else
        compopt -o filenames 2>/dev/null
        COMPREPLY=($(compgen -W "$subcommands" -- "$current") $(compgen -f -- "$current"))
    fi
}

complete -F _qs_tools qs-build qs-info qs-path qs-render qs-compare
