# What zsh offers for a command line, one word a line, read from a shell in a pseudo terminal.
#   zsh -f zsh_offers.zsh FOLDER_OF_COMPLETIONS LINE
zmodload zsh/zpty
zpty shell zsh -f -i
line() { zpty -w shell "$1"; }
line "PS1= PROMPT= ; stty -echo; fpath=(${(q)1} \$fpath); autoload -Uz compinit && compinit -u -D"
line "zstyle ':completion:*' list-grouped false; zstyle ':completion:*' verbose false; LISTMAX=0"
# The function that _arguments calls last gets every match; it notes them and adds none.
line "compadd() { local -a found; builtin compadd -O found \"\$@\"; print -l -- \"@\"\$^found; builtin compadd \"\$@\"; }"
line "print -r -- READY"
zpty -r shell out '*READY*READY*' 2>/dev/null
zpty -w -n shell "$2"$'\t'
zpty -w -n shell $'\x15'
line "print -r -- EN''D"
zpty -r shell out '*END*'
print -r -- "$out" | tr -d '\r' | grep -o '@--[a-z0-9-]*' | cut -c2- | sort -u
zpty -d shell
