MODULE Files
    ! Files, bytes, sockets: what RobotWare knows, never run.
    VAR iodev f;
    VAR dir dd;
    VAR rawbytes r;
    VAR socketdev k;
    VAR string s;
    VAR num n;
    VAR pos p;

    PROC main()
        Open "HOME:"\File:="a.txt",f\Append;
        Write f,"x"\Num:=3\NoNewLine;
        Close f;
        WHILE ReadDir(dd,s) DO ENDWHILE
        PackRawBytes 5,r,RawBytesLen(r)+1\IntX:=DINT;
        PackRawBytes n,r\Network,1\Float4;
        UnpackRawBytes r,1,s\ASCII:=10;
        SocketConnect k,"10.0.0.1",80\Time:=5;
        SocketSend k\RawData:=r;
        SocketReceive k\Str:=s\Time:=WAIT_MAX;
        IF SocketGetStatus(k)=SOCKET_CLOSED SocketClose k;
        IF s=EOF OR ReadNum(f)>EOF_NUM RETURN;
        s:=ValToStr(n)+StrMap(s,STR_LOWER,STR_UPPER);
        IF StrToVal(s,p) s:=ByteToStr(5\Hex);
        IF IsFile(s\Directory) RemoveFile s;
    ENDPROC
ENDMODULE
