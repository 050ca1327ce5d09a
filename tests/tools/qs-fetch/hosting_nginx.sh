# nginx as qs-hosting(7) sets it up.
source "$QS_SOURCE/tests/tools/qs-fetch/servers.bash"
needs nginx
prepare_hosting
mkdir nginx
user=
((EUID)) || user='user root;'
cat > nginx/conf << CONF
daemon off; worker_processes 1; pid $PWD/nginx/pid; error_log $PWD/nginx/error.log; $user
events {}
http {
    access_log off;
    client_body_temp_path $PWD/nginx/1; proxy_temp_path $PWD/nginx/2; fastcgi_temp_path $PWD/nginx/3;
    uwsgi_temp_path $PWD/nginx/4; scgi_temp_path $PWD/nginx/5;
    $(hosting_config "# /etc/nginx/conf.d/models.conf")
}
CONF
start nginx -c "$PWD/nginx/conf"
wait_for answers "$tls_port"
check_hosting
